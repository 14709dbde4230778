// Draws the view from above, on two canvases: the floor, which rarely changes, and all that moves above it.

import {FLAG, GRIP} from "./frames.js";
import {echoesOf, place, stateOf} from "./model.js";
import {roundLength} from "./view.js";

const NEAR = 0.5;           // m: an echo nearer than this is red, hatched and thick
const LEAST_BODY = 15;      // pixels: a robot is never drawn smaller
const FULL = 2 * Math.PI;

export class MapPicture {
  constructor(floor, moving, camera) {
    Object.assign(this, {floor, moving, camera, drawn: "", grid: null, gridOf: null});
    this.dress();
  }

  // Colours come from the style sheet: call this when they changed.
  dress() {
    const style = getComputedStyle(document.documentElement);
    this.colour = {};
    for (const name of ["floor", "beyond", "grid", "wall", "box", "ink", "ink2", "card", "trail", "cone", "echo", "can", "goal",
      "none", "bad", "person", "program", "still"])
      this.colour[name] = style.getPropertyValue("--" + name).trim();
    this.drawn = "";
    const tile = document.createElement("canvas"), ctx = tile.getContext("2d");
    tile.width = tile.height = 6;
    ctx.strokeStyle = this.colour.bad;
    ctx.lineWidth = 1.6;
    ctx.beginPath();
    for (const at of [-6, 0, 6]) {
      ctx.moveTo(at - 1, 7);
      ctx.lineTo(at + 7, -1);
    }
    ctx.stroke();
    this.hatch = ctx.createPattern(tile, "repeat");
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.moving, ratio = Math.min(3, window.devicePixelRatio || 1);
    for (const canvas of [this.floor, this.moving]) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.camera.resize(width, height);
  }

  draw(model, chosen) {
    const state = [this.camera.changes, model.worlds].join();
    if (state !== this.drawn) this.drawFloor(model.world);
    this.drawn = state;
    const ctx = this.moving.getContext("2d");
    ctx.clearRect(0, 0, this.camera.width, this.camera.height);
    ctx.lineJoin = ctx.lineCap = "round";
    const robots = model.list.filter(robot => robot.frame && robot !== chosen);
    if (chosen && chosen.frame) robots.push(chosen);            // above all others
    for (const robot of robots) this.drawTrail(ctx, model, robot, robot === chosen);
    if (robots.includes(chosen)) this.drawCones(ctx, chosen, model.pose(chosen));
    for (const robot of robots) this.drawEchoes(ctx, model, robot, robot === chosen);
    this.drawCans(ctx, model);
    for (const robot of robots) this.drawGoal(ctx, model, robot, robot === chosen);
    for (const robot of robots) this.drawBody(ctx, robot, model.pose(robot), robot === chosen);
    for (const robot of robots) this.drawLabel(ctx, robot, model.pose(robot), robot === chosen, robots.length < 5);
  }

  path(ctx, points, close) {
    ctx.beginPath();
    for (const [x, y] of points) ctx.lineTo(...this.camera.toScreen(x, y));
    if (close) ctx.closePath();
  }

  disc(ctx, x, y, radius) {
    const [px, py] = this.camera.toScreen(x, y);
    ctx.beginPath();
    ctx.arc(px, py, radius, 0, FULL);
  }

  // --- What stands still ---

  drawFloor(world) {
    const ctx = this.floor.getContext("2d"), {camera, colour} = this;
    const thick = Math.max(2, Math.min(6, 0.06 * camera.scale));
    ctx.lineJoin = ctx.lineCap = "round";
    ctx.fillStyle = world ? colour.beyond : colour.floor;
    ctx.fillRect(0, 0, camera.width, camera.height);
    if (world) {
      const [x1, y1, x2, y2] = world.bounds;
      if (world.grid) this.drawCells(ctx, world.grid);
      else {
        this.path(ctx, [[x1, y1], [x2, y1], [x2, y2], [x1, y2]], true);
        ctx.fillStyle = colour.floor;
        ctx.fill();
      }
    }
    this.drawGrid(ctx);
    if (world) {
      ctx.strokeStyle = colour.wall;
      ctx.fillStyle = colour.box;
      ctx.lineWidth = Math.max(1.5, thick / 2);
      for (const box of world.boxes || []) {
        this.path(ctx, box, true);
        ctx.fill();
        ctx.stroke();
      }
      for (const [x, y, radius] of world.posts || []) {
        this.disc(ctx, x, y, radius * camera.scale);
        ctx.fill();
        ctx.stroke();
      }
      ctx.lineWidth = thick;
      for (const [x1, y1, x2, y2] of world.walls || []) {
        this.path(ctx, [[x1, y1], [x2, y2]]);
        ctx.stroke();
      }
    }
    this.drawScale(ctx);
  }

  drawGrid(ctx) {
    const {camera} = this, step = Math.max(roundLength(camera.scale, 90), 0.1);
    const [left, top] = camera.toWorld(0, 0), [right, bottom] = camera.toWorld(camera.width, camera.height);
    ctx.strokeStyle = this.colour.grid;
    ctx.lineWidth = 1;
    ctx.beginPath();
    for (let x = Math.ceil(left / step) * step; x < right; x += step) {
      const px = Math.round(camera.toScreen(x, 0)[0]) + 0.5;
      ctx.moveTo(px, 0);
      ctx.lineTo(px, camera.height);
    }
    for (let y = Math.ceil(bottom / step) * step; y < top; y += step) {
      const py = Math.round(camera.toScreen(0, y)[1]) + 0.5;
      ctx.moveTo(0, py);
      ctx.lineTo(camera.width, py);
    }
    ctx.stroke();
  }

  // A scale bar at the lower left, on a ground of its own, so that it can be read above anything.
  drawScale(ctx) {
    const {camera, colour} = this, length = roundLength(camera.scale, 120), wide = length * camera.scale;
    const text = length < 1 ? Math.round(100 * length) + " cm" : length + " m", x = 14, y = camera.height - 14;
    ctx.fillStyle = colour.card;
    ctx.globalAlpha = 0.85;
    ctx.beginPath();
    ctx.roundRect(x - 8, y - 26, wide + 16, 34, 6);
    ctx.fill();
    ctx.globalAlpha = 1;
    ctx.fillStyle = colour.ink;
    ctx.font = this.font(12, 600);
    ctx.textAlign = "center";
    ctx.textBaseline = "alphabetic";
    ctx.fillText(text, x + wide / 2, y - 9);
    ctx.strokeStyle = colour.ink;
    ctx.lineCap = "butt";
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.moveTo(x, y - 6);
    ctx.lineTo(x, y);
    ctx.lineTo(x + wide, y);
    ctx.lineTo(x + wide, y - 6);
    ctx.stroke();
  }

  // A map of cells is painted once, and then laid down as a picture.
  drawCells(ctx, grid) {
    const {camera} = this;
    if (this.gridOf !== grid.cells + this.colour.floor) {
      const cells = atob(grid.cells), image = new ImageData(grid.width, grid.height);
      const shades = [this.colour.floor, this.colour.wall, this.colour.beyond].map(hex =>
        [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16)));
      for (let i = 0; i < cells.length; i++) image.data.set([...shades[cells.charCodeAt(i)] || shades[2], 255], 4 * i);
      this.grid = document.createElement("canvas");
      this.grid.width = grid.width;
      this.grid.height = grid.height;
      this.grid.getContext("2d").putImageData(image, 0, 0);
      this.gridOf = grid.cells + this.colour.floor;
    }
    const [x, y, heading] = grid.origin, scale = camera.scale * grid.resolution;
    ctx.save();
    ctx.translate(...camera.toScreen(x, y));
    ctx.rotate(-heading);
    ctx.scale(scale, -scale);
    ctx.imageSmoothingEnabled = false;
    ctx.drawImage(this.grid, 0, 0);
    ctx.restore();
  }

  // --- What moves ---

  // The way of a robot: the older, the paler, yet never too pale to see.
  drawTrail(ctx, model, robot, isChosen) {
    const {x, y, count} = robot.trail, origin = model.origin(robot.number), parts = isChosen ? 12 : 4;
    const first = Math.max(0, count - (isChosen ? 4000 : 60)), size = Math.ceil((count - first) / parts);
    ctx.strokeStyle = isChosen ? this.colour.trail : this.colour[stateOf(robot)[0]];
    ctx.lineWidth = isChosen ? 4.5 : 2.5;
    const lowest = isChosen ? 0.3 : 0.15, highest = isChosen ? 0.95 : 0.6;
    ctx.lineCap = "butt";                                       // round ends of pale parts would show as dots
    for (let part = 0; size > 0 && part < parts; part++) {
      const from = first + part * size, to = Math.min(count - 1, from + size);
      ctx.globalAlpha = lowest + (highest - lowest) * ((part + 1) / parts) ** 1.5;
      ctx.beginPath();
      for (let i = from; i <= to; i++) ctx.lineTo(...this.camera.toScreen(...place(origin, x[i], y[i])));
      if (to === count - 1) ctx.lineTo(...this.camera.toScreen(...place(origin, robot.frame.x, robot.frame.y)));
      ctx.stroke();
    }
    ctx.lineCap = "round";
    ctx.globalAlpha = 1;
  }

  // A sonar hears in a cone. What it heard is somewhere on the arc.
  drawCones(ctx, robot, pose) {
    const {sonar, sonar_cone: half} = robot.info;
    (sonar || []).forEach((one, i) => {
      const range = robot.frame.ranges[i];
      if (!one || !Number.isFinite(range)) return;
      const [px, py] = this.camera.toScreen(...place(pose, one[0], one[1]));
      const heading = -(pose.heading + one[2]), near = range < NEAR, radius = range * this.camera.scale;
      ctx.beginPath();
      ctx.moveTo(px, py);
      ctx.arc(px, py, radius, heading - half, heading + half);
      ctx.closePath();
      ctx.fillStyle = near ? this.hatch : this.colour.cone;
      ctx.globalAlpha = near ? 1 : 0.16;
      ctx.fill();
      ctx.globalAlpha = 1;
      ctx.beginPath();
      ctx.arc(px, py, radius, heading - half, heading + half);
      ctx.strokeStyle = near ? this.colour.bad : this.colour.cone;
      ctx.lineWidth = near ? 5 : 2;
      ctx.stroke();
    });
  }

  drawEchoes(ctx, model, robot, isChosen) {
    const origin = model.origin(robot.number);
    const dots = (echoes, size, alpha) => {
      ctx.globalAlpha = alpha;
      for (const [x, y] of echoes) {
        const [px, py] = this.camera.toScreen(...place(origin, x, y));
        ctx.fillRect(px - size / 2, py - size / 2, size, size);
      }
    };
    ctx.fillStyle = this.colour.echo;
    dots(robot.echoes, isChosen ? 3 : 2, isChosen ? 0.5 : 0.35);
    if (!isChosen) dots(echoesOf(robot.info, robot.frame), 3.5, 1);
    ctx.globalAlpha = 1;
  }

  // A can on the floor is full, a lifted one a ring.
  drawCans(ctx, model) {
    const radius = Math.max(4, ((model.world && model.world.can || {}).radius || 0.03) * this.camera.scale);
    ctx.lineWidth = 2;
    for (const [x, y, lifted] of model.cans) {
      this.disc(ctx, x, y, radius);
      ctx.fillStyle = lifted > 0.005 ? this.colour.card : this.colour.can;
      ctx.strokeStyle = lifted > 0.005 ? this.colour.can : this.colour.ink;
      ctx.fill();
      ctx.stroke();
    }
  }

  // A ring with a cross, and from the chosen robot a dotted line to it.
  drawGoal(ctx, model, robot, isChosen) {
    const goal = model.goals[robot.number];
    if (!goal) return;
    const [px, py] = this.camera.toScreen(...goal), pose = model.pose(robot);
    ctx.strokeStyle = ctx.fillStyle = this.colour.goal;
    if (isChosen) {
      ctx.setLineDash([2, 7]);
      ctx.lineWidth = 2.5;
      this.path(ctx, [[pose.x, pose.y], goal]);
      ctx.stroke();
      ctx.setLineDash([]);
    }
    ctx.lineWidth = 3;
    this.disc(ctx, ...goal, 9);
    ctx.moveTo(px - 14, py);
    ctx.lineTo(px + 14, py);
    ctx.moveTo(px, py - 14);
    ctx.lineTo(px, py + 14);
    ctx.stroke();
    this.text(ctx, String(robot.number), px, py - 22, this.colour.goal, 12);
  }

  // Grows a body that would be too small to see.
  grown(info) {
    const size = Math.max(...info.outline.map(each => Math.abs(each[0])), 0.1) * 2;
    return Math.max(1, LEAST_BODY / (size * this.camera.scale));
  }

  drawBody(ctx, robot, pose, isChosen) {
    const {info, frame} = robot, {colour} = this, grow = this.grown(info);
    const at = points => points.map(([x, y]) => place(pose, grow * x, grow * y));
    const xs = info.outline.map(each => each[0]), tip = Math.max(...xs), rear = Math.min(...xs);
    const fingers = frame.gripper & GRIP.fitted && info.outline.length > 4;      // the outline's tip is that of the paddles
    const front = fingers ? Math.max(...xs.filter(each => each < tip - 0.01)) : tip, long = front - rear;
    if (fingers) this.drawGripper(ctx, at, info, frame.gripper, front, tip);
    ctx.globalAlpha = robot.is(FLAG.link) ? 1 : 0.55;
    this.path(ctx, at(info.outline.filter(each => each[0] <= front + 0.001)), true);
    if (isChosen) {
      ctx.strokeStyle = colour.card;
      ctx.lineWidth = 7;
      ctx.stroke();
    }
    ctx.fillStyle = colour[stateOf(robot)[0]];
    ctx.fill();
    ctx.strokeStyle = colour.ink;
    ctx.lineWidth = isChosen ? 2.5 : 1.25;
    if (!robot.is(FLAG.link)) ctx.setLineDash([3, 3]);
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
    const wide = long * 0.28, from = front - 0.5 * long;
    this.path(ctx, at([[front - 0.08 * long, 0], [from, wide], [from + 0.1 * long, 0], [from, -wide]]), true);
    ctx.fillStyle = colour.card;
    ctx.fill();
    ctx.strokeStyle = colour.bad;
    ctx.lineWidth = 6;
    for (const [flag, x] of [[FLAG.bumpFront, front + 0.04], [FLAG.bumpRear, rear - 0.04]]) {
      if (!robot.is(flag)) continue;
      this.path(ctx, at([[x, -0.2], [x, 0.2]]));
      ctx.stroke();
    }
  }

  // Two paddles: apart, together, or between both while they move; with a disc where they hold something.
  drawGripper(ctx, at, info, state, front, tip) {
    const widest = Math.max(...info.outline.filter(each => each[0] > front + 0.001).map(each => Math.abs(each[1])));
    const gap = widest * (state & GRIP.moving ? 0.6 : state & GRIP.closed ? state & GRIP.holding ? 0.4 : 0.15 : 1);
    ctx.strokeStyle = this.colour.ink;
    ctx.lineWidth = Math.max(2, 0.025 * this.camera.scale);
    for (const points of [[[front, -widest], [front, widest]], [[front, gap], [tip, gap]], [[front, -gap], [tip, -gap]]]) {
      this.path(ctx, at(points));
      ctx.stroke();
    }
    if (!(state & GRIP.holding)) return;
    this.disc(ctx, ...at([[(front + tip) / 2, 0]])[0], Math.max(3, 0.03 * this.camera.scale));
    ctx.fillStyle = this.colour.can;
    ctx.fill();
  }

  font(size, weight) {
    return `${weight} ${size}px system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif`;
  }

  text(ctx, text, px, py, colour, size) {
    ctx.font = this.font(size, 700);
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.lineWidth = 3;
    ctx.strokeStyle = this.colour.card;
    ctx.strokeText(text, px, py);
    ctx.fillStyle = colour;
    ctx.fillText(text, px, py);
  }

  // Number, the name where there is room, and a sign for whatever is wrong, on a small plate beside the robot.
  drawLabel(ctx, robot, pose, isChosen, named) {
    const {colour, camera} = this, [kind, sign] = stateOf(robot), [px, py] = camera.toScreen(pose.x, pose.y);
    const size = isChosen ? 13 : camera.scale < 25 ? 10 : 11.5, high = size + 6;
    const name = named ? " " + robot.info.name : "", alarm = kind === "bad" || kind === "none" ? " " + sign : "";
    const text = robot.number + name + alarm;
    ctx.font = this.font(size, 700);
    const wide = Math.max(high, ctx.measureText(text).width + 10);
    const y = py - 0.32 * camera.scale * this.grown(robot.info) - high / 2 - 3;
    ctx.beginPath();
    ctx.roundRect(px - wide / 2, y - high / 2, wide, high, high / 2);
    ctx.fillStyle = isChosen ? colour.ink : colour.card;
    ctx.globalAlpha = isChosen ? 1 : 0.9;
    ctx.fill();
    ctx.globalAlpha = 1;
    ctx.lineWidth = 1.5;
    ctx.strokeStyle = colour[kind];
    ctx.stroke();
    ctx.fillStyle = isChosen ? colour.card : colour.ink;
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.fillText(text, px, y + 0.5);
  }

  // The robot under a place on the screen, or null.
  robotAt(model, px, py) {
    let nearest = null, least = 26;
    for (const robot of model.list) {
      if (!robot.frame) continue;
      const pose = model.pose(robot), [x, y] = this.camera.toScreen(pose.x, pose.y);
      const far = Math.max(0, Math.hypot(px - x, py - y) - Math.max(0, 0.25 * this.camera.scale - 10));
      if (far < least) [nearest, least] = [robot, far];
    }
    return nearest;
  }
}
