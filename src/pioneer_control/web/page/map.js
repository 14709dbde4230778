// Draws the view from above on two canvases: the floor, which rarely changes, and all that moves above it.

import {FLAG, GRIP} from "./frames.js";
import {echoesOf, place, stateOf} from "./model.js";
import {roundLength} from "./view.js";

const NEAR = 0.5;	// m: an echo nearer than this is red, hatched and thick
const LEAST = 15;	// pixels: no robot is drawn smaller
export const FONT = 'px system-ui, "DejaVu Sans", sans-serif';

// The colours of the style sheet.
export function colours() {
	const style = getComputedStyle(document.documentElement);
	return new Proxy({}, {get: (known, name) => known[name] = known[name] || style.getPropertyValue("--" + name).trim()});
}

// Makes a canvas as fine as the screen. Returns its context, in pixels of CSS.
export function sized(canvas, width, height) {
	const ratio = window.devicePixelRatio || 1, ctx = canvas.getContext("2d");
	Object.assign(canvas, {width: Math.round(width * ratio), height: Math.round(height * ratio)});
	ctx.scale(ratio, ratio);
	ctx.lineJoin = "round";
	return ctx;
}

export class MapPicture {
	constructor(floor, moving, camera) {
		Object.assign(this, {canvases: [floor, moving], camera, px: point => camera.toScreen(point)});
	}

	// The size or the colours changed.
	dress() {
		const {clientWidth: width, clientHeight: height} = this.canvases[1], tile = document.createElement("canvas");
		this.camera.set({width, height});
		[this.colour, this.shown, this.ctx] = [colours(), "", sized(tile, 6, 6)];
		for (const at of [-6, 0, 6]) this.lines([[at - 1, 7], [at + 7, -1]]).stroke("bad", 1.6);
		this.colour.hatch = this.ctx.createPattern(tile, "repeat");
		this.contexts = this.canvases.map(canvas => sized(canvas, width, height));
	}

	draw(model, chosen) {
		const {camera: {changes, width, height}} = this, shown = changes + "," + model.worlds;
		this.ctx = this.contexts[0];
		if (shown !== this.shown) this.drawFloor(model.world);
		[this.shown, this.ctx] = [shown, this.contexts[1]];
		this.ctx.clearRect(0, 0, width, height);
		const all = model.list.filter(robot => robot.frame).sort((a, b) => (a === chosen) - (b === chosen)).map(robot =>
			[robot, robot === chosen, model.pose(robot), model.origin(robot)]);
		for (const [robot, isChosen, pose] of all) if (isChosen) this.drawCones(robot, pose);
		for (const one of all) this.drawTrail(...one);
		for (const one of all) this.drawEchoes(...one);
		const radius = Math.max(4, (model.world && model.world.can ? model.world.can.radius : 0.03) * this.camera.scale);
		for (const can of model.cans) {		// a lifted one is a ring
			const up = can[2] > 0.005;
			this.disc(this.px(can), radius).fill(up ? "card" : "can").stroke(up ? "can" : "ink", 2);
		}
		for (const one of all) this.drawGoal(model.goals[one[0].number], ...one);
		for (const one of all) this.drawBody(...one);
		for (const one of all) this.drawLabel(...one, all.length < 5);
	}

	// --- Pencils: lines() and disc() take pixels, world() metres ---

	lines(points, close) {
		this.ctx.beginPath();
		for (const point of points) this.ctx.lineTo(...point);
		if (close) this.ctx.closePath();
		return this;
	}

	world(points, close) {
		return this.lines(points.map(this.px), close);
	}

	disc([px, py], radius, from = 0, to = 7) {
		this.ctx.beginPath();
		this.ctx.arc(px, py, radius, from, to);
		return this;
	}

	stroke(colour, lineWidth, globalAlpha = 1) {
		Object.assign(this.ctx, {strokeStyle: this.colour[colour], lineWidth, globalAlpha}).stroke();
		return this;
	}

	fill(colour, globalAlpha = 1) {
		Object.assign(this.ctx, {fillStyle: this.colour[colour], globalAlpha}).fill();
		return this;
	}

	// A text on a ground of its own: it can be read above anything.
	plate(text, px, py, size, edge, ink = "ink", ground = "card", least = 0) {
		const {ctx} = this, high = size + 6;
		Object.assign(ctx, {font: "700 " + size + FONT, textAlign: "center", textBaseline: "middle"});
		const wide = Math.max(least, high, ctx.measureText(text).width + 14);
		ctx.beginPath();
		ctx.roundRect(px - wide / 2, py - high / 2, wide, high, high / 2);
		this.fill(ground, 0.92).stroke(edge, 1.5);
		ctx.fillStyle = this.colour[ink];
		ctx.fillText(text, px, py + 0.5);
	}

	// --- What stands still ---

	drawFloor(world) {
		const {scale, width, height} = this.camera, thick = Math.max(2, Math.min(6, 0.06 * scale)), bar = roundLength(scale, 120);
		const {bounds: [x1, y1, x2, y2], grid, walls = [], boxes = [], posts = []} = world || {bounds: [0, 0, 0, 0]};
		this.ctx.lineCap = "round";
		this.lines([[0, 0], [width, 0], [width, height], [0, height]]).fill(world ? "beyond" : "floor");
		if (grid) this.drawCells(grid);
		else this.world([[x1, y1], [x2, y1], [x2, y2], [x1, y2]]).fill("floor");
		this.drawGrid(roundLength(scale, 90), width, height);
		for (const box of boxes) this.world(box, true).fill("box").stroke("wall", thick / 2);
		for (const post of posts) this.disc(this.px(post), post[2] * scale).fill("box").stroke("wall", thick / 2);
		for (const [ax, ay, bx, by] of walls) this.world([[ax, ay], [bx, by]]).stroke("wall", thick);
		const long = bar * scale, x = 18, y = height - 16;
		this.plate(bar < 1 ? Math.round(100 * bar) + " cm" : bar + " m", x + long / 2, y - 9, 12, "card", "ink", "card", long);
		this.lines([[x, y - 4], [x, y + 2], [x + long, y + 2], [x + long, y - 4]]).stroke("card", 5).stroke("ink", 2);
	}

	drawGrid(step, width, height) {
		const [left, top] = this.camera.toWorld([0, 0]), at = (i, axis) => Math.round(this.px([i * step, i * step])[axis]) + 0.5;
		for (let i = Math.ceil(left / step); at(i, 0) < width; i++) this.lines([[at(i, 0), 0], [at(i, 0), height]]).stroke("grid", 1);
		for (let i = Math.floor(top / step); at(i, 1) < height; i--) this.lines([[0, at(i, 1)], [width, at(i, 1)]]).stroke("grid", 1);
	}

	// A map of cells is painted once, and then laid down as a picture.
	drawCells({cells, width, height, resolution, origin}) {
		const {ctx, colour} = this, key = cells + colour.floor, scale = this.camera.scale * resolution;
		if (this.cellsOf !== key) {
			const image = new ImageData(width, height), shades = [colour.floor, colour.wall, colour.beyond].map(hex =>
				[1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16)));
			[...atob(cells)].forEach((cell, i) => image.data.set([...shades[cell.charCodeAt()] || shades[2], 255], 4 * i));
			this.cells = Object.assign(document.createElement("canvas"), {width, height});
			this.cells.getContext("2d").putImageData(image, 0, 0);
			this.cellsOf = key;
		}
		ctx.save();
		ctx.translate(...this.px(origin));
		ctx.rotate(-origin[2]);
		ctx.scale(scale, -scale);
		ctx.imageSmoothingEnabled = false;
		ctx.drawImage(this.cells, 0, 0);
		ctx.restore();
	}

	// --- What moves. All get a robot, whether it is the chosen one, its pose, and where its odometry begins ---

	// The way of a robot: the older, the paler, yet never too pale to see.
	drawTrail(robot, isChosen, pose, origin) {
		const {trail, count} = robot, parts = isChosen ? 12 : 4, first = Math.max(0, count - (isChosen ? 4000 : 60));
		const size = Math.ceil((count - first) / parts);
		this.ctx.lineCap = "butt";		// round ends of pale parts would show as dots
		for (let from = first, part = 1; from < count; from += size, part++) {
			const points = trail.slice(from, Math.min(count, from + size + 1)).map(point => place(origin, point));
			if (from + size >= count) points.push([pose.x, pose.y]);
			this.world(points).stroke(...isChosen ? ["trail", 4.5, 0.3 + 0.65 * (part / parts) ** 1.5] :
				[stateOf(robot)[0], 2.5, 0.15 + 0.4 * part / parts]);
		}
	}

	// A sonar hears in a cone. What it heard is somewhere on the arc.
	drawCones({info, frame}, pose) {
		for (const [i, one] of (info.sonar || []).entries()) {
			const range = frame.ranges[i], near = range < NEAR;
			if (!one || !Number.isFinite(range)) continue;
			const at = this.px(place(pose, one)), heading = -pose.heading - one[2], half = info.sonar_cone;
			this.disc(at, range * this.camera.scale, heading - half, heading + half).ctx.lineTo(...at);
			this.fill(near ? "hatch" : "cone", near ? 1 : 0.15);
			this.disc(at, range * this.camera.scale, heading - half, heading + half).stroke(near ? "bad" : "cone", near ? 5 : 2);
		}
	}

	// Of the chosen robot those that it heard lately: its cones show what it hears now.
	drawEchoes(robot, isChosen, pose, origin) {
		Object.assign(this.ctx, {fillStyle: this.colour.echo, globalAlpha: 0.7});
		for (const echo of isChosen ? robot.echoes : echoesOf(robot.info, robot.frame)) {
			const [px, py] = this.px(place(origin, echo));
			this.ctx.fillRect(px - 1.5, py - 1.5, 3, 3);
		}
	}

	drawGoal(goal, robot, isChosen, pose) {
		if (!goal) return;
		const [px, py] = this.px(goal);
		this.ctx.setLineDash([2, 6]);
		if (isChosen) this.world([[pose.x, pose.y], goal]).stroke("goal", 2.5);
		this.ctx.setLineDash([]);
		this.disc([px, py], 8).stroke("goal", 3);
		for (const [dx, dy] of [[13, 0], [0, 13]]) this.lines([[px - dx, py - dy], [px + dx, py + dy]]).stroke("goal", 3);
		this.plate("goal " + robot.number, px, py - 24, 10.5, "goal");
	}

	// How much a body grows that would be too small to see.
	grown({outline}) {
		return Math.max(1, LEAST / (2 * this.camera.scale * Math.max(0.1, ...outline.map(each => Math.abs(each[0])))));
	}

	drawBody(robot, isChosen, pose) {
		const {info: {outline}, frame: {gripper}} = robot, grow = this.grown(robot.info), linked = robot.is(FLAG.link);
		const at = (points, close) => this.world(points.map(([x, y]) => place(pose, [grow * x, grow * y])), close);
		const xs = outline.map(each => each[0]), tip = Math.max(...xs), rear = Math.min(...xs);
		const nose = gripper && outline.length > 4;		// the tip of the outline is that of the paddles
		const front = nose ? Math.max(...xs.filter(x => x < tip - 0.01)) : tip, long = front - rear;
		if (nose) this.drawGripper(at, gripper, front, tip, Math.max(...outline.filter(each => each[0] === tip).map(each => each[1])));
		at(outline.filter(each => each[0] <= front), true);
		if (isChosen) this.stroke("card", 7);
		this.ctx.setLineDash(linked ? [] : [3, 3]);
		this.fill(stateOf(robot)[0], linked ? 1 : 0.5).stroke("ink", isChosen ? 2.5 : 1.25);
		this.ctx.setLineDash([]);
		const head = front - 0.08 * long, from = head - 0.47 * long, wide = 0.28 * long;
		at([[head, 0], [from, wide], [from + 0.12 * long, 0], [from, -wide]], true).fill("card");
		for (const [flag, x] of [[FLAG.bumpFront, front + 0.04], [FLAG.bumpRear, rear - 0.04]])
			if (robot.is(flag)) at([[x, -0.2], [x, 0.2]]).stroke("bad", 6);
	}

	// Two paddles: apart, together, or between both while they move; a disc where they hold something.
	drawGripper(at, state, front, tip, wide) {
		const holds = state & GRIP.holding, thick = Math.max(2, 0.03 * this.camera.scale);
		const gap = wide * (state & GRIP.moving ? 0.6 : !(state & GRIP.closed) ? 1 : holds ? 0.4 : 0.15);
		for (const way of [-1, 1]) at([[front, way * wide], [front, way * gap], [tip, way * gap]]).stroke("ink", thick);
		if (holds) at([[tip - 0.1, 0], [tip - 0.04, 0]]).stroke("can", 2 * thick);
	}

	// Number, the name where there is room, and a sign for whatever is wrong.
	drawLabel(robot, isChosen, pose, origin, named) {
		const {number, info} = robot, [kind, sign] = stateOf(robot), [px, py] = this.px([pose.x, pose.y]), {scale} = this.camera;
		const size = isChosen ? 13 : scale < 25 ? 10 : 11.5, above = 0.34 * scale * this.grown(info) + size;
		const text = number + (named ? " " + info.name : "") + (kind === "bad" || kind === "none" ? " " + sign : "");
		this.plate(text, px, py - above, size, kind, ...isChosen ? ["card", "ink"] : []);
	}

	// The robot under a place on the screen.
	robotAt(model, at) {
		const far = robot => {
			const {x, y} = model.pose(robot), [px, py] = this.px([x, y]);
			return Math.hypot(px - at[0], py - at[1]);
		};
		return model.list.filter(robot => robot.frame && far(robot) < Math.max(26, 0.3 * this.camera.scale)).sort((a, b) => far(a) - far(b))[0];
	}
}
