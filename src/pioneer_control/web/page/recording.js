// A recording as a source: fills the model with what was at a time. Any moment is found by halving, never by replaying.

import {decodeColumns, frameAt, lastNotAbove} from "./frames.js";
import {echoesOf} from "./model.js";

const TRAIL_STEP = 30;      // mm between two points of a trail
const ECHO_ROWS = 20;       // rows whose echoes are shown

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Texts by what they are about: at a time, the last one of each counts.
export function indexOf(messages) {
  const index = new Map();
  for (const [at, message] of messages) {
    for (const [kind, value] of Object.entries(message)) {
      const about = kind === "status" || kind === "helm" ? kind + value.robot : kind;
      if (!index.has(about)) index.set(about, {kind, times: [], values: [], shown: -1});
      const one = index.get(about);
      one.times.push(at);
      one.values.push(value);
    }
  }
  return index;
}

export class Recording {
  constructor(value, model) {
    Object.assign(this, {model, duration: value.duration, marks: value.marks || [], name: value.name, start: value.start,
      at: 0, columns: new Map(), index: indexOf(value.messages)});
    this.wanted = value.columns;
    model.take("hello", {title: value.name, kind: "recording"});
  }

  // The columns that came with the text (one file), base64.
  async unpackAll() {
    for (const {robot, data} of this.wanted)
      if (data) await this.unpack(robot, Uint8Array.from(atob(data), each => each.charCodeAt(0)));
  }

  async unpackMessage(buffer) {
    await this.unpack(new DataView(buffer).getUint16(1, true), new Uint8Array(buffer, 3));
  }

  async unpack(robot, packed) {
    const {rows, sonar} = this.wanted.find(each => each.robot === robot);
    const columns = decodeColumns(await inflate(packed), rows, sonar), trail = {x: [], y: [], rows: []};
    for (let row = 0, x = Infinity, y = Infinity; row < rows; row++) {
      if (Math.hypot(columns.x[row] - x, columns.y[row] - y) < TRAIL_STEP) continue;
      x = columns.x[row];
      y = columns.y[row];
      trail.x.push(x / 1000);
      trail.y.push(y / 1000);
      trail.rows.push(row);
    }
    this.columns.set(robot, {...columns, trail});
    this.seek(this.at);
  }

  seek(at) {
    const {model} = this;
    this.at = at = Math.max(0, Math.min(this.duration, at));
    for (const [about, one] of this.index) {
      if (about === "trail") continue;
      const last = lastNotAbove(one.times, at);
      if (about === "said" && last !== one.shown) {
        model.log = [];
        for (const said of one.values.slice(Math.max(0, last - 50), last + 1)) model.hear(said);
      } else if (last !== one.shown && last >= 0) model.take(one.kind, one.values[last]);
      else if (last !== one.shown) model.forget(one.kind, one.values[0]);
      one.shown = last;
    }
    for (const robot of model.list) this.place(robot, 1000 * at);
  }

  place(robot, ms) {
    const columns = this.columns.get(robot.number), row = columns ? lastNotAbove(columns.time, ms) : -1;
    if (row < 0) return void Object.assign(robot, {frame: null, echoes: [], trail: {x: [], y: [], count: 0}});
    const {trail} = columns, info = robot.info;
    robot.frame = frameAt(columns, row, robot.number);
    robot.trail = {x: trail.x, y: trail.y, count: lastNotAbove(trail.rows, row) + 1};
    robot.echoes = [];
    for (let each = Math.max(0, row - 2 * ECHO_ROWS); each < row; each += 2)
      robot.echoes.push(...echoesOf(info, frameAt(columns, each, robot.number)));
  }

  // How long (s) before now the last thing was heard of a robot.
  age(robot) {
    return robot.frame ? this.at - robot.frame.stamp / 1000 : Infinity;
  }

  // The next mark (1) or the one before (-1) of a robot, or of none.
  mark(number, way) {
    const ours = this.marks.filter(mark => mark.robot === number || mark.robot === null || mark.robot === undefined);
    return way > 0 ? ours.find(mark => mark.at > this.at + 0.05) : ours.reverse().find(mark => mark.at < this.at - 0.05);
  }

  // The curve of one column for the time line: [time s, value] pairs, thinned to so many.
  curve(number, name, most) {
    if (name === "battery") {
      const one = this.index.get("status" + number) || {times: [], values: []};
      return one.times.map((at, i) => [at, (one.values[i].battery || {}).volts]).filter(each => each[1] > 0);
    }
    const columns = this.columns.get(number), found = [];
    if (!columns) return found;
    const step = Math.max(1, Math.floor(columns.rows / most));
    for (let from = 0; from < columns.rows; from += step) {        // of each step that which stands out most
      let best = from;
      for (let row = from; row < Math.min(columns.rows, from + step); row++)
        if (Math.abs(columns[name][row]) > Math.abs(columns[name][best])) best = row;
      found.push([columns.time[best] / 1000, columns[name][best] / 1000]);
    }
    return found;
  }
}
