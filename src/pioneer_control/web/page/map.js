// Draws the view from above on two canvases: the floor, which rarely changes, and all that moves above it.

import {FLAG, GRIP} from "./frames.js";
import {echoesOf, place, stateOf} from "./model.js";
import {roundLength} from "./view.js";

const NEAR = 0.5;		// m: an echo nearer than this is red, hatched and thick
const LEAST = 15;		// pixels: no robot is drawn smaller
const FONT = 'px system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';

// The colours of the style sheet, which has them for light and dark.
export function colours() {
	const style = getComputedStyle(document.documentElement);
	return new Proxy({}, {get: (known, name) => known[name] = known[name] || style.getPropertyValue("--" + name).trim()});
}

// Makes a canvas as fine as the screen. Returns its context, in pixels of CSS.
export function sized(canvas, width, height) {
	const ratio = Math.min(3, window.devicePixelRatio || 1), ctx = canvas.getContext("2d");
	canvas.width = Math.round(width * ratio);
	canvas.height = Math.round(height * ratio);
	ctx.scale(ratio, ratio);
	return ctx;
}

export class MapPicture {
	constructor(floor, moving, camera) {
		Object.assign(this, {floor, moving, camera});
	}

	// The size or the colours changed.
	dress() {
		const {clientWidth: width, clientHeight: height} = this.moving;
		this.contexts = [this.floor, this.moving].map(canvas => sized(canvas, width, height));
		for (const ctx of this.contexts) ctx.lineJoin = "round";
		this.colour = colours();
		this.shown = "";
		this.camera.set({width, height});
		const tile = document.createElement("canvas");
		tile.width = tile.height = 6;
		this.ctx = tile.getContext("2d");
		for (const at of [-6, 0, 6]) this.lines([[at - 1, 7], [at + 7, -1]]).stroke("bad", 1.6);
		this.colour.hatch = this.ctx.createPattern(tile, "repeat");
	}

	draw(model, chosen) {
		const shown = [this.camera.changes, model.worlds].join();
		this.ctx = this.contexts[0];
		if (shown !== this.shown) this.drawFloor(model.world);
		this.shown = shown;
		this.ctx = this.contexts[1];
		this.ctx.clearRect(0, 0, this.camera.width, this.camera.height);
		const robots = model.list.filter(robot => robot.frame).sort((one, other) => (one === chosen) - (other === chosen));
		for (const robot of robots) this.drawTrail(model.origin(robot), robot, robot === chosen);
		if (robots.includes(chosen)) this.drawCones(chosen, model.pose(chosen));
		for (const robot of robots) this.drawEchoes(model.origin(robot), robot, robot === chosen);
		this.drawCans(model);
		for (const robot of robots) this.drawGoal(model.goals[robot.number], robot, robot === chosen && model.pose(robot));
		for (const robot of robots) this.drawBody(robot, model.pose(robot), robot === chosen);
		for (const robot of robots) this.drawLabel(robot, model.pose(robot), robot === chosen, robots.length < 5);
	}

	// --- Pencils. All but world() take pixels ---

	lines(points, close) {
		this.ctx.beginPath();
		for (const point of points) this.ctx.lineTo(...point);
		if (close) this.ctx.closePath();
		return this;
	}

	world(points, close) {
		return this.lines(points.map(point => this.camera.toScreen(point)), close);
	}

	disc([px, py], radius) {
		this.ctx.beginPath();
		this.ctx.arc(px, py, radius, 0, 7);
		return this;
	}

	stroke(colour, width, alpha = 1) {
		Object.assign(this.ctx, {strokeStyle: this.colour[colour], lineWidth: width, globalAlpha: alpha});
		this.ctx.stroke();
		return this;
	}

	fill(colour, alpha = 1) {
		Object.assign(this.ctx, {fillStyle: this.colour[colour], globalAlpha: alpha});
		this.ctx.fill();
		return this;
	}

	// A text on a plate of its own: it can be read above anything.
	plate(text, px, py, size, ink, ground, edge, least = size + 6) {
		const {ctx} = this, high = size + 6;
		Object.assign(ctx, {font: "700 " + size + FONT, textAlign: "center", textBaseline: "middle"});
		const wide = Math.max(least, ctx.measureText(text).width + 10);
		ctx.beginPath();
		ctx.roundRect(px - wide / 2, py - high / 2, wide, high, high / 2);
		this.fill(ground, 0.92).stroke(edge, 1.5);
		ctx.fillStyle = this.colour[ink];
		ctx.fillText(text, px, py + 0.5);
	}

	// --- What stands still ---

	drawFloor(world) {
		const {camera} = this, thick = Math.max(2, Math.min(6, 0.06 * camera.scale)), {width, height} = camera;
		this.ctx.lineCap = "round";
		this.lines([[0, 0], [width, 0], [width, height], [0, height]]).fill(world ? "beyond" : "floor");
		const {bounds: [x1, y1, x2, y2], grid, walls = [], boxes = [], posts = []} = world || {bounds: [0, 0, 0, 0]};
		if (grid) this.drawCells(grid); else this.world([[x1, y1], [x2, y1], [x2, y2], [x1, y2]]).fill("floor");
		this.drawGrid(roundLength(camera.scale, 90));
		for (const box of boxes) this.world(box, true).fill("box").stroke("wall", thick / 2);
		for (const [x, y, radius] of posts)
			this.disc(camera.toScreen([x, y]), radius * camera.scale).fill("box").stroke("wall", thick / 2);
		for (const [ax, ay, bx, by] of walls) this.world([[ax, ay], [bx, by]]).stroke("wall", thick);
		const length = roundLength(camera.scale, 120), wide = length * camera.scale, x = 18, y = height - 16;
		this.plate(length < 1 ? Math.round(100 * length) + " cm" : length + " m", x + wide / 2, y - 9, 12, "ink", "card", "card", wide);
		this.ctx.lineCap = "butt";
		this.lines([[x, y - 4], [x, y + 2], [x + wide, y + 2], [x + wide, y - 4]]).stroke("card", 5).stroke("ink", 2);
	}

	drawGrid(step) {
		const {camera} = this, {width, height} = camera, [left, top] = camera.toWorld([0, 0]);
		for (let i = Math.ceil(left / step), px; (px = Math.round(camera.toScreen([i * step, 0])[0]) + 0.5) < width; i++)
			this.lines([[px, 0], [px, height]]).stroke("grid", 1);
		for (let i = Math.floor(top / step), py; (py = Math.round(camera.toScreen([0, i * step])[1]) + 0.5) < height; i--)
			this.lines([[0, py], [width, py]]).stroke("grid", 1);
	}

	// A map of cells is painted once, and then laid down as a picture.
	drawCells(grid) {
		const {ctx, colour} = this, scale = this.camera.scale * grid.resolution, key = grid.cells + colour.floor;
		if (this.cellsOf !== key) {
			const cells = atob(grid.cells);
			this.cells = document.createElement("canvas");
			Object.assign(this.cells, {width: grid.width, height: grid.height});
			const image = new ImageData(grid.width, grid.height), shades = [colour.floor, colour.wall, colour.beyond].map(hex =>
				[1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16)));
			for (let i = 0; i < cells.length; i++) image.data.set([...shades[cells.charCodeAt(i)] || shades[2], 255], 4 * i);
			this.cells.getContext("2d").putImageData(image, 0, 0);
			this.cellsOf = key;
		}
		ctx.save();
		ctx.translate(...this.camera.toScreen(grid.origin));
		ctx.rotate(-grid.origin[2]);
		ctx.scale(scale, -scale);
		ctx.imageSmoothingEnabled = false;
		ctx.drawImage(this.cells, 0, 0);
		ctx.restore();
	}

	// --- What moves ---

	// The way of a robot: the older, the paler, yet never too pale to see.
	drawTrail(origin, robot, isChosen) {
		const {trail, count, frame} = robot, parts = isChosen ? 12 : 4, first = Math.max(0, count - (isChosen ? 4000 : 60));
		const size = Math.ceil((count - first) / parts);
		for (let from = first, part = 1; from < count; from += size, part++) {
			const points = trail.slice(from, Math.min(count, from + size + 1));
			if (from + size >= count) points.push([frame.x, frame.y]);
			this.world(points.map(point => place(origin, point)));
			if (isChosen) this.stroke("trail", 4.5, 0.3 + 0.65 * (part / parts) ** 1.5);
			else this.stroke(stateOf(robot)[0], 2.5, 0.15 + 0.4 * part / parts);
		}
	}

	// A sonar hears in a cone. What it heard is somewhere on the arc.
	drawCones({info, frame}, pose) {
		(info.sonar || []).forEach((one, i) => {
			const range = frame.ranges[i];
			if (!one || !Number.isFinite(range)) return;
			const [px, py] = this.camera.toScreen(place(pose, one)), heading = -(pose.heading + one[2]), near = range < NEAR;
			const arc = () => this.ctx.arc(px, py, range * this.camera.scale, heading - info.sonar_cone, heading + info.sonar_cone);
			this.lines([[px, py]]);
			arc();
			this.fill(near ? "hatch" : "cone", near ? 1 : 0.15);
			this.ctx.beginPath();
			arc();
			this.stroke(near ? "bad" : "cone", near ? 5 : 2);
		});
	}

	// Of the chosen robot also those that it heard lately: its cones show where it hears now.
	drawEchoes(origin, robot, isChosen) {
		Object.assign(this.ctx, {fillStyle: this.colour.echo, globalAlpha: isChosen ? 0.6 : 0.8});
		for (const echo of isChosen ? robot.echoes : echoesOf(robot.info, robot.frame)) {
			const [px, py] = this.camera.toScreen(place(origin, echo));
			this.ctx.fillRect(px - 1.5, py - 1.5, 3, 3);
		}
	}

	// A can on the floor is full, a lifted one a ring.
	drawCans({cans, world}) {
		const radius = Math.max(4, (world && world.can ? world.can.radius : 0.03) * this.camera.scale);
		for (const [x, y, lifted] of cans)
			this.disc(this.camera.toScreen([x, y]), radius).fill(lifted > 0.005 ? "card" : "can").stroke(lifted > 0.005 ? "can" : "ink", 2);
	}

	// A ring with a cross, and from the chosen robot, whose pose is given, a dotted line to it.
	drawGoal(goal, robot, pose) {
		if (!goal) return;
		const [px, py] = this.camera.toScreen(goal);
		this.ctx.setLineDash([2, 6]);
		if (pose) this.world([[pose.x, pose.y], goal]).stroke("goal", 2.5);
		this.ctx.setLineDash([]);
		this.disc([px, py], 8).stroke("goal", 3);
		for (const [dx, dy] of [[13, 0], [0, 13]]) this.lines([[px - dx, py - dy], [px + dx, py + dy]]).stroke("goal", 3);
		this.plate("goal " + robot.number, px, py - 24, 10.5, "ink", "card", "goal");
	}

	// How much a body grows that would be too small to see.
	grown({outline}) {
		return Math.max(1, LEAST / (2 * this.camera.scale * Math.max(0.1, ...outline.map(each => Math.abs(each[0])))));
	}

	drawBody(robot, pose, isChosen) {
		const {info: {outline}, frame: {gripper}} = robot, grow = this.grown(robot.info);
		const at = (points, close) => this.world(points.map(([x, y]) => place(pose, [grow * x, grow * y])), close);
		const xs = outline.map(each => each[0]), tip = Math.max(...xs), rear = Math.min(...xs);
		const paddles = gripper && outline.length > 4 ? outline.filter(each => each[0] > tip - 0.01) : [];
		const front = paddles.length ? Math.max(...xs.filter(x => x <= tip - 0.01)) : tip, long = front - rear;
		if (paddles.length) this.drawGripper(at, gripper, front, tip, Math.max(...paddles.map(each => each[1])));
		const alpha = robot.is(FLAG.link) ? 1 : 0.55;
		at(outline.filter(each => each[0] <= front), true);
		if (isChosen) this.stroke("card", 7);
		this.ctx.setLineDash(alpha < 1 ? [3, 3] : []);
		this.fill(stateOf(robot)[0], alpha).stroke("ink", isChosen ? 2.5 : 1.25, alpha);
		this.ctx.setLineDash([]);
		const nose = front - 0.08 * long, from = front - 0.55 * long, wide = 0.28 * long;
		at([[nose, 0], [from, wide], [from + 0.12 * long, 0], [from, -wide]], true).fill("card");
		for (const [flag, x] of [[FLAG.bumpFront, front + 0.04], [FLAG.bumpRear, rear - 0.04]])
			if (robot.is(flag)) at([[x, -0.2], [x, 0.2]]).stroke("bad", 6);
	}

	// Two paddles: apart, together, or between both while they move; a disc where they hold something.
	drawGripper(at, state, front, tip, widest) {
		const holds = state & GRIP.holding, closed = holds ? 0.4 : 0.15;
		const gap = widest * (state & GRIP.moving ? 0.6 : state & GRIP.closed ? closed : 1);
		for (const points of [[[front, -widest], [front, widest]], [[front, gap], [tip, gap]], [[front, -gap], [tip, -gap]]])
			at(points).stroke("ink", Math.max(2, 0.03 * this.camera.scale));
		if (holds) at([[tip - 0.07, 0], [tip - 0.07, 0]]).stroke("can", Math.max(6, 0.06 * this.camera.scale));
	}

	// Number, the name where there is room, and a sign for whatever is wrong.
	drawLabel(robot, pose, isChosen, named) {
		const {camera} = this, [kind, sign] = stateOf(robot), [px, py] = camera.toScreen([pose.x, pose.y]);
		const size = isChosen ? 13 : camera.scale < 25 ? 10 : 11.5, above = 0.34 * camera.scale * this.grown(robot.info);
		const text = robot.number + (named ? " " + robot.info.name : "") + (kind === "bad" || kind === "none" ? " " + sign : "");
		this.plate(text, px, py - above - size, size, isChosen ? "card" : "ink", isChosen ? "ink" : "card", kind);
	}

	// The robot under a place on the screen.
	robotAt(model, [px, py]) {
		const far = robot => {
			const pose = model.pose(robot), [x, y] = this.camera.toScreen([pose.x, pose.y]);
			return Math.hypot(px - x, py - y);
		};
		const near = Math.max(26, 0.3 * this.camera.scale);
		return model.list.filter(robot => robot.frame && far(robot) < near).sort((one, other) => far(one) - far(other))[0];
	}
}
