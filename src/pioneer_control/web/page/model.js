// All that is known of the robots now. A live server and a recording fill the same model; all else only reads it.

import {FLAG} from "./frames.js";

const STEP = 0.03;		// m between two points of a trail
const JUMP = 1;			// m: it was carried
const MOST = 6000;		// points of a trail
const UNTOLD = {status: {link: "ok", faults: []}, helm: {locks: [], limit: [0.2, 0.6]}, program: {}, navigation: {}, plan: {}, cloud: {}, places: {}};	// until the server tells
const NOTHING = {world: null, origins: {}, cans: [], goals: {}, task: null, log: []};

// A point in the frame of a pose (x, y, heading), in the frame that the pose is in.
export function place([left, top, heading], [x, y]) {
	const cos = Math.cos(heading), sin = Math.sin(heading);
	return [left + x * cos - y * sin, top + x * sin + y * cos];
}

class Robot {
	constructor(number) {
		Object.assign(this, {number, frame: null, sent: 0, trail: [], ...UNTOLD});
	}

	is(flags) {
		return (this.frame?.flags & flags) > 0;
	}

	get locked() {
		return this.is(FLAG.locked) || this.helm.locks.length > 0;
	}

	take(frame, sent) {
		const {trail} = this, [x, y] = trail[trail.length - 1] || [], way = Math.hypot(frame.x - x, frame.y - y);
		Object.assign(this, {frame, sent});
		if (way < STEP) return;
		if (way > JUMP) trail.length = 0;
		if (trail.push([frame.x, frame.y]) > MOST) trail.splice(0, MOST / 4);
	}
}

export class Model {
	list = [];

	constructor() {
		this.forget();
	}

	forget() {
		Object.assign(this, NOTHING);
		for (const robot of this.list) Object.assign(robot, UNTOLD);
	}

	robot(number) {
		return this.list.find(robot => robot.number === number);
	}

	take(kind, value) {
		const robot = this.robot(value?.robot);
		this.navigates ||= /goals|nav|cloud/.test(kind);
		if (kind === "robots") this.list = value.map(info => Object.assign(this.robot(info.robot) || new Robot(info.robot), {info}))
			.sort((a, b) => a.number - b.number);
		else if (kind === "said") this.log = [...this.log.slice(-7), value];
		else if (kind in UNTOLD && robot) robot[kind] = {...UNTOLD[kind], ...value};
		else if (kind === "trail" && robot) robot.trail = value.points;
		else if (kind in NOTHING) this[kind] = value;
	}

	origin(robot) {
		return this.origins[robot.number] || [0, 0, 0];
	}

	pose(robot) {
		const origin = this.origin(robot), {x, y, heading} = robot.frame;
		return [...place(origin, [x, y]), origin[2] + heading];
	}
}

// How a robot is: [kind, for the colour; sign; word]. The worst comes first.
export function stateOf(robot) {
	const {status: {link, faults}, helm: {commander}} = robot;
	if (!robot.is(FLAG.link) || link !== "ok") return ["still", "?", "no link"];
	if (robot.is(FLAG.button)) return ["error", "■", "STOP button"];
	if (robot.locked) return ["error", "■", "stopped"];
	if (robot.is(FLAG.stallLeft | FLAG.stallRight)) return ["error", "!", "stalled"];
	if (robot.is(FLAG.bumpFront | FLAG.bumpRear)) return ["error", "!", "bumped"];
	if (faults.some(fault => fault.level === "error")) return ["error", "!", "fault"];
	if (commander === "person") return ["person", "◆", "by hand"];
	if (commander === "program") return ["program", "▶", "program"];
	return ["still", ...robot.is(FLAG.motors) ? ["●", "stands"] : ["○", "off"]];
}
