// Draws the view from above on two canvases: the floor, and all that moves above it.
// Lengths are m in the map or the frame of a robot; widths of lines: pixels.

import {FLAG, GRIP} from "./frames.js";
import {place, stateOf} from "./model.js";
import {roundLength} from "./view.js";

const NEAR = 0.5;	// m: an echo nearer than this is red, with a thick arc
const LEAST = 10;	// pixels: the smallest radius of a robot

export function colours() {
	const style = getComputedStyle(document.documentElement);
	return new Proxy({}, {get: (known, name) => known[name] ||= style.getPropertyValue("--" + name)});
}

// A canvas as fine as the screen: its context, in pixels of CSS.
export function sized(canvas) {
	const {clientWidth, clientHeight} = canvas, ratio = devicePixelRatio, ctx = canvas.getContext("2d");
	Object.assign(canvas, {width: clientWidth * ratio, height: clientHeight * ratio});
	ctx.scale(ratio, ratio);
	return Object.assign(ctx, {lineJoin: "round", lineCap: "round", textAlign: "center", textBaseline: "middle", font: "bold 12px system-ui, sans-serif"});
}

export class MapPicture {
	constructor(floor, moving, camera) {
		Object.assign(this, {canvases: [floor, moving], camera});
	}

	dress() {
		const [floor] = this.canvases;
		Object.assign(this.camera, {width: floor.clientWidth, height: floor.clientHeight});
		Object.assign(this, {colour: colours(), contexts: this.canvases.map(sized), grid: null, floor: null});
	}

	draw(model, chosen) {
		const {world, cans} = model, {scale} = this.camera, floor = [world, ...Object.values(this.camera)];
		if (floor.some((each, i) => each !== this.floor?.[i])) this.drawFloor(world || {bounds: [0, 0, 0, 0]});
		this.floor = floor;
		const robots = model.list.filter(robot => robot.frame).sort((a, b) => (a === chosen) - (b === chosen)).map(robot => {
			const reach = Math.max(0.1, ...robot.info.outline.map(point => Math.hypot(...point)));
			return {robot, mine: robot === chosen, pose: model.pose(robot), origin: model.origin(robot), reach, grown: Math.max(1, LEAST / scale / reach)};
		});
		this.onCanvas(1, () => {
			for (const can of cans) this.disc(can, Math.max(4 / scale, world?.can?.radius || 0)).fill("can").stroke("ink", 2);
			for (const layer of ["drawCones", "drawTrail", "drawEchoes", "drawBody"]) for (const each of robots) this[layer](each);
		});
		for (const {robot, mine, pose, reach, grown} of robots) {
			const [kind, sign] = stateOf(robot), text = robot.number + ("■!?".includes(sign) ? " " + sign : "");
			this.plate(text, pose, reach * grown * scale + 12, kind, ...mine ? ["card", "ink"] : []);
		}
		this.robots = robots;
	}

	robotAt(pixel) {
		const [x, y] = this.camera.toWorld(pixel), far = ({pose}) => Math.hypot(pose[0] - x, pose[1] - y);
		return this.robots.filter(each => far(each) < Math.max(26 / this.camera.scale, 0.3)).sort((a, b) => far(a) - far(b))[0]?.robot.number;
	}

	onCanvas(number, draw) {
		const {x, y, scale, width, height} = this.camera;
		Object.assign(this, {ctx: this.contexts[number], scale: 1});
		this.ctx.clearRect(0, 0, width, height);
		this.within([width / 2, height / 2, 0], scale, () => {
			this.ctx.transform(1, 0, 0, -1, -x, y);
			draw();
		});
	}

	within([x, y, heading], size, draw) {
		const {scale} = this;
		this.scale *= size;
		this.ctx.save();
		this.ctx.translate(x, y);
		this.ctx.rotate(heading);
		this.ctx.scale(size, size);
		draw();
		this.ctx.restore();
		this.scale = scale;
	}

	path(...points) {
		this.ctx.beginPath();
		for (const point of points) this.ctx.lineTo(...point);
		return this;
	}

	area(...points) {
		return this.path(...points, points[0]);
	}

	box(x1, y1, x2, y2) {
		return this.area([x1, y1], [x2, y1], [x2, y2], [x1, y2]);
	}

	disc([x, y], radius, half = Math.PI) {
		this.ctx.beginPath();
		this.ctx.arc(x, y, radius, -half, half);
		return this;
	}

	stroke(colour, pixels, globalAlpha = 1) {
		Object.assign(this.ctx, {strokeStyle: this.colour[colour], lineWidth: pixels / this.scale, globalAlpha}).stroke();
		return this;
	}

	fill(colour, globalAlpha = 1) {
		Object.assign(this.ctx, {fillStyle: this.colour[colour], globalAlpha}).fill();
		return this;
	}

	// A text on its own ground, so many pixels above a place: it can be read above anything.
	plate(text, place, above, edge, ink = "ink", ground = "card") {
		const {ctx, colour} = this, [x, low] = this.camera.toScreen(place), y = low - above, half = Math.max(0.1, ctx.measureText(text).width / 2 - 3);
		this.path([x - half, y], [x + half, y]);
		for (const [strokeStyle, lineWidth] of [[colour[edge], 19.5], [colour[ground], 16.5]]) Object.assign(ctx, {strokeStyle, lineWidth}).stroke();
		ctx.fillStyle = colour[ink];
		ctx.fillText(text, x, y + 0.5);
	}

	drawFloor({bounds: [x1, y1, x2, y2], grid, walls = [], boxes = [], posts = [], places = []}) {
		const {camera} = this, {scale, width, height} = camera, thick = Math.max(2, Math.min(6, 0.06 * scale));
		const [left, top] = camera.toWorld([0, 0]), [right, bottom] = camera.toWorld([width, height]);
		const bar = roundLength(scale, Math.min(120, width / 5)), [from, low] = camera.toWorld([18, height - 20]);
		this.onCanvas(0, () => {
			if (grid) this.drawCells(grid);
			else this.box(x1, y1, x2, y2).fill("card");
			for (let x = Math.ceil(left / bar) * bar; x < right; x += bar) this.path([x, top], [x, bottom]).stroke("line", 1, 0.6);
			for (let y = Math.ceil(bottom / bar) * bar; y < top; y += bar) this.path([left, y], [right, y]).stroke("line", 1, 0.6);
			for (const {centre: [x, y], diameter, size: [wide, high] = []} of places)
				(diameter ? this.disc([x, y], diameter / 2) : this.box(x - wide / 2, y - high / 2, x + wide / 2, y + high / 2)).fill("goal", 0.15).stroke("goal", 2);
			for (const box of boxes) this.area(...box).fill("wall", 0.3).stroke("wall", thick / 2);
			for (const post of posts) this.disc(post, post[2]).fill("wall", 0.3).stroke("wall", thick / 2);
			for (const [ax, ay, bx, by] of walls) this.path([ax, ay], [bx, by]).stroke("wall", thick);
			this.path([from, low], [from + bar, low]).stroke("ink", 3);
		});
		this.plate(+bar.toFixed(2) + " m", [from + bar / 2, low], 15, "card");
		for (const {name, centre, diameter, size = [diameter]} of places) if (size[0] * scale > 20) this.plate(name, centre, size.at(-1) * scale / 2 + 12, "goal");
	}

	drawCells(grid) {
		const {cells, width, height, resolution, origin} = grid;
		if (this.grid !== grid) {
			Object.assign(this, {grid, cells: Object.assign(document.createElement("canvas"), {width, height})});
			const ctx = this.cells.getContext("2d");
			[...atob(cells)].forEach((cell, i) => {
				ctx.fillStyle = this.colour[["card", "wall", "page"][cell.charCodeAt()]];
				ctx.fillRect(i % width, i / width | 0, 1, 1);
			});
		}
		this.ctx.imageSmoothingEnabled = false;
		this.within(origin, resolution, () => this.ctx.drawImage(this.cells, 0, 0));
	}

	// What a sonar heard is somewhere on the arc of its cone. `mine` is the chosen robot.
	drawCones({robot: {info, frame}, mine, pose}) {
		this.within(pose, 1, () => (mine ? info.sonar : []).forEach((one, i) => {
			const range = frame.ranges[i], near = range < NEAR, colour = near ? "error" : "can";
			if (one && range < Infinity) this.within(one, 1, () => {
				this.disc([0, 0], range, info.sonar_cone).stroke(colour, near ? 5 : 2).ctx.lineTo(0, 0);
				this.fill(colour, near ? 0.4 : 0.15);
			});
		}));
	}

	drawTrail({robot: {trail, frame: {x, y}}, mine, origin}) {
		this.within(origin, 1, () => {
			this.path(...trail.slice(mine ? 0 : -60), [x, y]).stroke("program", mine ? 4 : 2, 0.5);
		});
	}

	drawEchoes({robot: {info, frame}, mine, pose}) {
		if (!mine) this.within(pose, 1, () => {
			const size = 4 / this.scale;
			this.path().fill("program", 0.7);
			info.sonar.forEach((one, i) => {
				if (!one || !(frame.ranges[i] < Infinity)) return;
				const [x, y] = place(one, [frame.ranges[i], 0]);
				this.ctx.fillRect(x - size / 2, y - size / 2, size, size);
			});
		});
	}

	drawBody({robot, mine, pose, grown}) {
		const {info: {outline}, frame: {gripper}} = robot, xs = outline.map(([x]) => x), tip = Math.max(...xs), linked = robot.is(FLAG.link);
		const front = gripper && outline.length > 4 ? Math.max(...xs.filter(x => x < tip - 0.01)) : tip, head = front - 0.04;
		const gap = gripper & (GRIP.moving | GRIP["holds something"]) ? 0.06 : gripper & GRIP.closed ? 0.02 : 0.12;
		this.within(pose, grown, () => {
			if (front < tip) for (const y of [-gap, gap]) this.path([front, y], [tip, y]).stroke("ink", Math.max(2, 0.03 * this.scale));
			if (gripper & GRIP["holds something"]) this.disc([tip - 0.05, 0], 0.03).fill("can");
			this.area(...outline.filter(([x]) => x <= front));
			if (mine) this.stroke("card", 7);
			this.fill(stateOf(robot)[0], linked ? 1 : 0.4).stroke("ink", mine ? 2.5 : 1.25);
			this.area([head, 0], [head - 0.3, 0.17], [head - 0.2, 0], [head - 0.3, -0.17]).fill("card");
		});
	}
}
