// Reads the bytes of a server: frames of robots, and columns of a recording (docs/page-protocol.md).
// In a frame are m, rad and s; a range is Infinity where there was no echo, NaN where nothing was heard.

export const FLAG = {link: 1, motors: 2, button: 4, stallLeft: 8, stallRight: 16, bumpFront: 32, bumpRear: 64, locked: 256, charging: 512};
export const GRIP = {moving: 8, open: 2, closed: 4, "lift moving": 64, up: 16, down: 32, "holds something": 128};
const FIELDS = [["robot", 16], ["stamp", 32], ["age", 16, 1000], ["x", -32, 1000], ["y", -32, 1000], ["heading", 16, 32768 / Math.PI],
	["linear", -16, 1000], ["angular", -16, 1000], ["flags", 16], ["gripper", 8]];		// bits (-: signed), and units in one
const COLUMNS = ["time", ...FIELDS.slice(3).map(([name]) => name)];

function rangeOf(byte) {
	return byte <= 250 ? byte / 50 : byte === 251 ? Infinity : NaN;
}

// All frames of a message. One that is cut short raises a RangeError.
export function decodeFrames(buffer) {
	const view = new DataView(buffer), frames = [];
	for (let at = 1; at < view.byteLength;) {
		const frame = {};
		for (const [name, bits, unit = 1] of FIELDS) {
			frame[name] = view[`get${bits < 0 ? "Int" : "Uint"}${Math.abs(bits)}`](at, true) / unit;
			at += Math.abs(bits) / 8;
		}
		const length = view.getUint8(at++);
		frame.ranges = Array.from({length}, () => rangeOf(view.getUint8(at++)));
		frames.push(frame);
	}
	return frames;
}

// Columns of one robot, unpacked: each number was written as its difference to the one before.
export function decodeColumns(buffer, rows, sonar) {
	const count = COLUMNS.length + sonar, view = new DataView(buffer), columns = {rows, ranges: []};
	if (buffer.byteLength !== 4 * rows * count) throw new Error("columns of a wrong length");
	for (let column = 0; column < count; column++) {
		const numbers = new Int32Array(rows);
		for (let row = 0, sum = 0; row < rows; row++) numbers[row] = sum += view.getInt32(4 * (column * rows + row), true);
		if (column < COLUMNS.length) columns[COLUMNS[column]] = numbers; else columns.ranges.push(numbers);
	}
	return columns;
}

// One row of a recording as a frame. Its stamp is the time since the start (ms).
export function frameAt(columns, row, robot) {
	const frame = {robot, stamp: columns.time[row], age: 0, ranges: columns.ranges.map(each => rangeOf(each[row]))};
	for (const [name, , unit = 1] of FIELDS.slice(3)) frame[name] = columns[name][row] / unit;
	return frame;
}
