// Reads the bytes that a server sends: frames of robots, and columns of a recording (docs/page-protocol.md).
// A frame has m, rad and s; a range is Infinity where there was no echo, NaN where nothing was heard.

export const FLAG = {link: 1, motors: 2, button: 4, stallLeft: 8, stallRight: 16, bumpFront: 32, bumpRear: 64, sonar: 128,
    locked: 256, charging: 512};
export const GRIP = {fitted: 1, open: 2, closed: 4, moving: 8, up: 16, down: 32, lifting: 64, holding: 128};
const RADIANS = 2 * Math.PI / 65536;

export function rangeOf(byte) {
  return byte <= 250 ? byte * 0.02 : byte === 251 ? Infinity : NaN;
}

// All frames of a message. One that is cut short raises a RangeError.
export function decodeFrames(buffer) {
  const view = new DataView(buffer), frames = [];
  for (let at = 1; at < view.byteLength;) {
    const n = view.getUint8(at + 25);
    frames.push({
      robot: view.getUint16(at, true), stamp: view.getUint32(at + 2, true), age: view.getUint16(at + 6, true) / 1000,
      x: view.getInt32(at + 8, true) / 1000, y: view.getInt32(at + 12, true) / 1000,
      heading: view.getUint16(at + 16, true) * RADIANS,
      linear: view.getInt16(at + 18, true) / 1000, angular: view.getInt16(at + 20, true) / 1000,
      flags: view.getUint16(at + 22, true), gripper: view.getUint8(at + 24),
      ranges: Array.from({length: n}, (_, i) => rangeOf(view.getUint8(at + 26 + i))),
    });
    at += 26 + n;
  }
  return frames;
}

export const COLUMNS = ["time", "x", "y", "heading", "linear", "angular", "flags", "gripper"];

// Columns of one robot, unpacked: each number was written as its difference to the one before.
export function decodeColumns(bytes, rows, sonar) {
  const count = COLUMNS.length + sonar;
  if (bytes.byteLength !== 4 * rows * count) throw new Error("columns of a wrong length");
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), columns = {rows, ranges: []};
  for (let column = 0; column < count; column++) {
    const numbers = new Int32Array(rows);
    for (let row = 0, sum = 0; row < rows; row++) {
      sum = sum + view.getInt32(4 * (column * rows + row), true) | 0;
      numbers[row] = sum;
    }
    if (column < COLUMNS.length) columns[COLUMNS[column]] = numbers; else columns.ranges.push(numbers);
  }
  return columns;
}

// One row of a recording as a frame. Its stamp is the time since the start (ms).
export function frameAt(columns, row, robot) {
  return {
    robot, stamp: columns.time[row], age: 0, x: columns.x[row] / 1000, y: columns.y[row] / 1000,
    heading: columns.heading[row] * RADIANS, linear: columns.linear[row] / 1000, angular: columns.angular[row] / 1000,
    flags: columns.flags[row], gripper: columns.gripper[row], ranges: columns.ranges.map(each => rangeOf(each[row])),
  };
}

// The last place in a sorted list whose number is not above the limit; -1 where all are.
export function lastNotAbove(numbers, limit) {
  let low = -1, high = numbers.length;
  while (high - low > 1) {
    const middle = low + high >> 1;
    if (numbers[middle] <= limit) low = middle; else high = middle;
  }
  return low;
}
