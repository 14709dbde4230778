// A recording: fills the model with what was at any moment, found by halving, never by playing from the start.

import {decodeColumns, frameAt, lastNotAbove} from "./frames.js";
import {echoesOf} from "./model.js";

const APART = 30;	// mm between two points of a trail
const ROWS = 40;	// whose echoes are shown
const NOTHING = {robots: [], world: null, origins: {}, cans: [], goals: {}};	// before the first word of a kind

// The bytes that were compressed.
export async function unpacked(packed) {
	return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

// Texts by what they are about: at any time, the last one of each counts.
export function indexOf(messages) {
	const index = new Map();
	for (const [at, message] of messages) for (const [kind, value] of Object.entries(message)) {
		const robot = kind === "status" || kind === "helm" ? value.robot : "", about = kind + robot;
		if (!index.has(about)) index.set(about, {kind, robot, times: [], values: []});
		index.get(about).times.push(at);
		index.get(about).values.push(value);
	}
	index.delete("trail");	// the columns know the way
	return index;
}

export class Recording {
	constructor(value, model) {
		Object.assign(this, {marks: [], ...value, model, at: 0, unpacked: new Map(), index: indexOf(value.messages)});
	}

	async unpack(robot, packed) {
		const {rows, sonar} = this.columns.find(each => each.robot === robot), trail = [], trailRows = [];
		const columns = decodeColumns(new Uint8Array(await unpacked(packed)), rows, sonar), {x, y} = columns;
		for (let row = 0, last = -1; row < rows; row++) {
			if (last >= 0 && Math.hypot(x[row] - x[last], y[row] - y[last]) < APART) continue;
			trail.push([x[row] / 1000, y[row] / 1000]);
			trailRows.push(last = row);
		}
		this.unpacked.set(robot, {...columns, trail, trailRows});
	}

	seek(at) {
		const {model} = this;
		this.at = Math.max(0, Math.min(this.duration, at));
		for (const [about, one] of this.index) {
			const last = lastNotAbove(one.times, this.at);
			if (about === "said") {
				model.log = [];
				one.values.slice(Math.max(0, last - 20), last + 1).forEach(said => model.hear(said));
			} else if (last !== one.shown || one.robot)		// a robot that came back knows nothing
				model.take(one.kind, last >= 0 ? one.values[last] : NOTHING[one.kind] || {robot: one.robot});
			one.shown = last;
		}
		for (const robot of model.list) this.place(robot, this.unpacked.get(robot.number));
	}

	place(robot, columns) {
		const row = columns ? lastNotAbove(columns.time, 1000 * this.at) : -1, frame = each => frameAt(columns, each, robot.number);
		Object.assign(robot, {frame: null, trail: [], echoes: []});
		if (row < 0) return;
		Object.assign(robot, {frame: frame(row), trail: columns.trail.slice(0, lastNotAbove(columns.trailRows, row) + 1)});
		for (let each = Math.max(0, row - ROWS); each < row; each += 2) robot.echoes.push(...echoesOf(robot.info, frame(each)));
	}

	marksOf(number) {
		return this.marks.filter(mark => [number, null, undefined].includes(mark.robot));
	}

	// Speeds for the time line: [time s, m/s], of each of so many parts what stands out most.
	speeds(number, parts) {
		const {rows = 0, time, linear} = this.unpacked.get(number) || {}, found = [], size = Math.ceil(rows / parts);
		for (let from = 0; from < rows; from += size) {
			let best = from;
			for (let row = from; row < Math.min(rows, from + size); row++) if (Math.abs(linear[row]) > Math.abs(linear[best])) best = row;
			found.push([time[best] / 1000, linear[best] / 1000]);
		}
		return found;
	}
}
