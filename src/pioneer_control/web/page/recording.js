// A recording: fills the model with what was at any moment.

import {decodeColumns, frameAt} from "./frames.js";

const STEP_ROWS = 5;	// between two points of a trail

export function unpacked(packed) {
	return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate")));
}

export class Recording {
	constructor(value, model) {
		Object.assign(this, {marks: [], ...value, model, at: value.at || 0, said: 0, unpacked: new Map()});
	}

	async unpack(robot, packed) {
		const {rows, sonar} = this.columns.find(each => each.robot === robot), columns = decodeColumns(await unpacked(packed).arrayBuffer(), rows, sonar);
		const trail = Array.from({length: rows / STEP_ROWS}, (_, i) => [columns.x[i * STEP_ROWS] / 1000, columns.y[i * STEP_ROWS] / 1000]);
		this.unpacked.set(robot, {...columns, trail});
	}

	// What was said is said anew from where we were, or from the start to go back.
	seek(at) {
		const {model, messages} = this, back = at < this.at;
		this.at = Math.max(0, Math.min(this.duration, at));
		if (back) {
			model.forget();
			this.said = 0;
		}
		while (messages[this.said]?.[0] <= this.at) model.take(...Object.entries(messages[this.said++][1])[0]);
		for (const robot of model.list) this.place(robot, this.unpacked.get(robot.number));
	}

	place(robot, columns) {
		const row = columns ? columns.time.findLastIndex(time => time <= 1000 * this.at) : -1;
		robot.frame = row < 0 ? null : frameAt(columns, row, robot.number);
		robot.trail = row < 0 ? [] : columns.trail.slice(0, row / STEP_ROWS + 1);
	}
}
