// Draws the view from above on two canvases: the floor, which rarely changes, and all that moves above it.

import {FLAG, GRIP} from "./frames.js";
import {echoesOf, place, stateOf} from "./model.js";
import {roundLength} from "./view.js";

const NEAR = 0.5;	// m: an echo nearer than this is red, and its cone has thick edges
const LEAST = 18;	// pixels: no robot is drawn smaller
export const FONT = "px system-ui, sans-serif";

// The colours of the style sheet.
export function colours() {
	const style = getComputedStyle(document.documentElement);
	return new Proxy({}, {get: (known, name) => known[name] ||= style.getPropertyValue("--" + name).trim()});
}

// Makes a canvas as fine as the screen. Returns its context, in pixels of CSS.
export function sized(canvas) {
	const ratio = window.devicePixelRatio, {clientWidth, clientHeight} = canvas, ctx = canvas.getContext("2d");
	Object.assign(canvas, {width: Math.round(clientWidth * ratio), height: Math.round(clientHeight * ratio)});
	ctx.scale(ratio, ratio);
	return Object.assign(ctx, {lineJoin: "round", textAlign: "center", textBaseline: "middle"});
}

// How far the body of a robot reaches from its middle (m).
function reach({info: {outline}}) {
	return Math.max(0.1, ...outline.map(([x, y]) => Math.hypot(x, y)));
}

export class MapPicture {
	constructor(floor, moving, camera) {
		Object.assign(this, {canvases: [floor, moving], camera, px: point => camera.toScreen(point)});
	}

	// The size or the colours changed.
	dress() {
		const {clientWidth: width, clientHeight: height} = this.canvases[1];
		this.camera.set({width, height});
		Object.assign(this, {colour: colours(), contexts: this.canvases.map(sized), changes: -1});
	}

	draw(model, chosen) {
		const {camera, contexts} = this, {changes, width, height} = camera, {world} = model;
		this.ctx = contexts[0];
		if (changes !== this.changes || world !== this.drawn) this.drawFloor(world);
		Object.assign(this, {changes, drawn: world, ctx: contexts[1]});
		this.ctx.clearRect(0, 0, width, height);
		const radius = Math.max(4, (world?.can?.radius || 0.03) * camera.scale);
		for (const can of model.cans) {		// a lifted one is a ring
			const up = can[2] > 0.005;
			this.disc(this.px(can), radius).fill(up ? "card" : "can").stroke(up ? "can" : "ink", 2);
		}
		const robots = model.list.filter(robot => robot.frame).sort((a, b) => (a === chosen) - (b === chosen)).map(robot =>
			({robot, isChosen: robot === chosen, pose: model.pose(robot), origin: model.origin(robot), goal: model.goals[robot.number]}));
		for (const layer of ["Cones", "Trail", "Echoes", "Goal", "Body", "Label"]) for (const each of robots) this["draw" + layer](each);
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
	plate(text, px, py, edge, ink = "ink", ground = "card") {
		this.ctx.font = 700 + " 12" + FONT;
		const wide = Math.max(18, this.ctx.measureText(text).width + 12);
		this.ctx.beginPath();
		this.ctx.roundRect(px - wide / 2, py - 9, wide, 18, 9);
		this.fill(ground).stroke(edge, 1.5);
		this.ctx.fillStyle = this.colour[ink];
		this.ctx.fillText(text, px, py + 0.5);
	}

	// --- What stands still ---

	drawFloor(world) {
		const {camera: {scale, width, height}, ctx} = this, thick = Math.max(2, Math.min(6, 0.06 * scale));
		const {bounds: [x1, y1, x2, y2], grid, walls = [], boxes = [], posts = []} = world || {bounds: [0, 0, 0, 0]};
		ctx.lineCap = "round";
		this.lines([[0, 0], [width, 0], [width, height], [0, height]]).fill(world ? "page" : "card");
		if (grid) this.drawCells(grid);
		else this.world([[x1, y1], [x2, y1], [x2, y2], [x1, y2]]).fill("card");
		this.drawGrid(roundLength(scale, 90), width, height);
		for (const box of boxes) this.world(box, true).fill("wall", 0.3).stroke("wall", thick / 2);
		for (const post of posts) this.disc(this.px(post), post[2] * scale).fill("wall", 0.3).stroke("wall", thick / 2);
		for (const [ax, ay, bx, by] of walls) this.world([[ax, ay], [bx, by]]).stroke("wall", thick);
		const bar = roundLength(scale, Math.min(120, width / 5)), right = 18 + bar * scale, y = height - 18;
		this.lines([[18, y - 6], [18, y], [right, y], [right, y - 6]]).stroke("page", 6).stroke("ink", 2);
		this.plate(bar < 1 ? Math.round(100 * bar) + " cm" : bar + " m", 9 + right / 2, y - 13, "card");
	}

	drawGrid(step, width, height) {
		const [left, top] = this.camera.toWorld([0, 0]), at = (i, axis) => Math.round(this.px([i * step, i * step])[axis]) + 0.5;
		for (let i = Math.ceil(left / step); at(i, 0) < width; i++) this.lines([[at(i, 0), 0], [at(i, 0), height]]).stroke("line", 1, 0.5);
		for (let i = Math.floor(top / step); at(i, 1) < height; i--) this.lines([[0, at(i, 1)], [width, at(i, 1)]]).stroke("line", 1, 0.5);
	}

	// A map of cells is painted once, and then laid down as a picture.
	drawCells({cells, width, height, resolution, origin}) {
		const {ctx, colour} = this, scale = this.camera.scale * resolution, key = cells + colour.card;
		if (this.cellsOf !== key) {
			const image = new ImageData(width, height), shades = [colour.card, colour.wall, colour.page].map(hex =>
				[1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16)));
			[...atob(cells)].forEach((cell, i) => image.data.set([...shades[cell.charCodeAt()] || shades[2], 255], 4 * i));
			Object.assign(this, {cellsOf: key, cells: new OffscreenCanvas(width, height)});
			this.cells.getContext("2d").putImageData(image, 0, 0);
		}
		ctx.save();
		ctx.translate(...this.px(origin));
		ctx.rotate(-origin[2]);
		ctx.scale(scale, -scale);
		ctx.imageSmoothingEnabled = false;
		ctx.drawImage(this.cells, 0, 0);
		ctx.restore();
	}

	// --- What moves. All get a robot, whether it is the chosen one, its pose, where its odometry begins, and its goal ---

	// A sonar hears in a cone. What it heard is somewhere on the arc.
	drawCones({robot: {info, frame}, isChosen, pose}) {
		for (const [i, one] of (isChosen ? info.sonar : []).entries()) {
			const range = frame.ranges[i], near = range < NEAR;
			if (!one || !Number.isFinite(range)) continue;
			const at = this.px(place(pose, one)), heading = -pose.heading - one[2], half = info.sonar_cone;
			const arc = () => this.disc(at, range * this.camera.scale, heading - half, heading + half);
			arc().ctx.lineTo(...at);
			this.ctx.closePath();
			this.fill(near ? "bad" : "can", near ? 0.3 : 0.15);
			(near ? this : arc()).stroke(near ? "bad" : "can", near ? 3.5 : 2);
		}
	}

	// The way of a robot: the older, the paler, yet never too pale to see.
	drawTrail({robot, isChosen, pose, origin}) {
		const trail = robot.trail.slice(isChosen ? -4000 : -60), size = Math.ceil(trail.length / 8);
		this.ctx.lineCap = "butt";		// round ends of pale parts would show as dots
		for (let part = 1; size && part <= 8; part++) {
			const points = trail.slice((part - 1) * size, part * size + 1).map(point => place(origin, point));
			if (part === 8) points.push([pose.x, pose.y]);
			this.world(points).stroke(isChosen ? "program" : stateOf(robot)[0], isChosen ? 4 : 2, (isChosen ? 0.3 : 0.1) + part / 16);
		}
	}

	// Of the chosen robot those that it heard lately: its cones show what it hears now.
	drawEchoes({robot, isChosen, origin}) {
		Object.assign(this.ctx, {fillStyle: this.colour.program, globalAlpha: 0.7});
		for (const echo of isChosen ? robot.echoes : echoesOf(robot.info, robot.frame)) {
			const [px, py] = this.px(place(origin, echo));
			this.ctx.fillRect(px - 1.5, py - 1.5, 3, 3);
		}
	}

	drawGoal({robot, isChosen, pose, goal}) {
		if (!goal) return;
		const [px, py] = this.px(goal);
		this.ctx.setLineDash([2, 6]);
		if (isChosen) this.world([[pose.x, pose.y], goal]).stroke("goal", 2.5);
		this.ctx.setLineDash([]);
		this.disc([px, py], 8).stroke("goal", 3);
		for (const [dx, dy] of [[13, 0], [0, 13]]) this.lines([[px - dx, py - dy], [px + dx, py + dy]]).stroke("goal", 3);
		this.plate("goal " + robot.number, px, py - 26, "goal");
	}

	// How much a body grows that would be too small to see.
	grown(robot) {
		return Math.max(1, LEAST / (2 * this.camera.scale * reach(robot)));
	}

	drawBody({robot, isChosen, pose}) {
		const {info: {outline}, frame: {gripper}} = robot, grow = this.grown(robot), linked = robot.is(FLAG.link);
		const at = (points, close) => this.world(points.map(([x, y]) => place(pose, [grow * x, grow * y])), close);
		const xs = outline.map(([x]) => x), tip = Math.max(...xs), rear = Math.min(...xs);
		const nose = gripper && outline.length > 4;		// the tip of the outline is that of the paddles
		const front = nose ? Math.max(...xs.filter(x => x < tip - 0.01)) : tip, head = front - 0.08 * (front - rear);
		if (nose) this.drawGripper(at, gripper, front, tip, Math.max(...outline.filter(([x]) => x === tip).map(([, y]) => y)));
		at(outline.filter(([x]) => x <= front), true);
		if (isChosen) this.stroke("card", 7);
		this.ctx.setLineDash(linked ? [] : [3, 3]);
		this.fill(stateOf(robot)[0], linked ? 1 : 0.5).stroke("ink", isChosen ? 2.5 : 1.25);
		this.ctx.setLineDash([]);
		at([[head, 0], [head - 0.24, 0.14], [head - 0.18, 0], [head - 0.24, -0.14]], true).fill("card");
		for (const [flag, x] of [[FLAG.bumpFront, front + 0.04], [FLAG.bumpRear, rear - 0.04]])
			if (robot.is(flag)) at([[x, -0.2], [x, 0.2]]).stroke("bad", 6);
	}

	// Two paddles: apart, together, or between both while they move; a disc where they hold something.
	drawGripper(at, state, front, tip, wide) {
		const holds = state & GRIP["holds something"], thick = Math.max(2, 0.03 * this.camera.scale);
		const gap = wide * (state & GRIP.moving ? 0.6 : !(state & GRIP.closed) ? 1 : holds ? 0.4 : 0.15);
		for (const way of [-1, 1]) at([[front, way * wide], [front, way * gap], [tip, way * gap]]).stroke("ink", thick);
		if (holds) at([[tip - 0.1, 0], [tip - 0.04, 0]]).stroke("can", 2 * thick);
	}

	// The number, above the body wherever it heads, and a sign for what is wrong.
	drawLabel({robot, isChosen, pose}) {
		const [kind, sign] = stateOf(robot), [px, py] = this.px([pose.x, pose.y]), above = reach(robot) * this.camera.scale * this.grown(robot) + 12;
		this.plate(robot.number + (kind === "bad" || kind === "none" ? " " + sign : ""), px, py - above, kind, ...isChosen ? ["card", "ink"] : []);
	}

	// The robot under a place on the screen.
	robotAt(model, [x, y]) {
		const far = robot => {
			const {x: wx, y: wy} = model.pose(robot), [px, py] = this.px([wx, wy]);
			return Math.hypot(px - x, py - y);
		};
		return model.list.filter(robot => robot.frame && far(robot) < Math.max(26, reach(robot) * this.camera.scale))
			.sort((a, b) => far(a) - far(b))[0];
	}
}
