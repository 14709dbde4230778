// All that is known of the robots now. A live server and a recording fill the same model; everything else only reads it.

import {FLAG} from "./frames.js";

const STEP = 0.03;          // m between two points of a trail
const MOST = 6000;          // points of a trail
const ECHOES = 240;         // remembered of a robot

export class Robot {
  constructor(number) {
    Object.assign(this, {number, info: null, frame: null, sent: 0, status: {}, helm: {}, trail: {x: [], y: [], count: 0},
      echoes: []});
  }

  // Tells whether a flag of the newest frame is set.
  is(flag) {
    return this.frame !== null && (this.frame.flags & flag) !== 0;
  }

  get locked() {
    return this.is(FLAG.locked) || (this.helm.locks || []).length > 0;
  }

  get faults() {
    return this.status.faults || [];
  }

  take(frame, sent) {
    const {trail} = this, last = trail.count - 1;
    this.frame = frame;
    this.sent = sent;
    if (last < 0 || Math.hypot(frame.x - trail.x[last], frame.y - trail.y[last]) >= STEP) {
      trail.x.push(frame.x);
      trail.y.push(frame.y);
      if (++trail.count > MOST) for (const each of [trail.x, trail.y]) trail.count = each.splice(0, MOST / 4) && each.length;
      this.echoes.push(...echoesOf(this.info, frame));
      if (this.echoes.length > ECHOES) this.echoes.splice(0, this.echoes.length - ECHOES);
    }
  }
}

// A place in base_link of a pose, in the frame of that pose.
export function place(pose, x, y) {
  const cos = Math.cos(pose.heading), sin = Math.sin(pose.heading);
  return [pose.x + x * cos - y * sin, pose.y + x * sin + y * cos];
}

// Where the sonar of a frame heard something, in the odometry frame.
export function echoesOf(info, frame) {
  const found = [];
  ((info && info.sonar) || []).forEach((one, i) => {
    const range = frame.ranges[i];
    if (one && Number.isFinite(range))
      found.push(place(frame, one[0] + range * Math.cos(one[2]), one[1] + range * Math.sin(one[2])));
  });
  return found;
}

export class Model {
  constructor() {
    this.clear();
  }

  clear() {
    Object.assign(this, {hello: {}, all: new Map(), list: [], world: null, origins: {}, cans: [], goals: {}, log: [],
      worlds: 0});
  }

  robot(number) {
    if (!this.all.has(number)) this.all.set(number, new Robot(number));
    return this.all.get(number);
  }

  // Takes one text of the server. Kinds that are not known are left.
  take(kind, value) {
    if (kind === "robots") this.takeRobots(value);
    else if (kind === "status" || kind === "helm") this.robot(value.robot)[kind] = value;
    else if (kind === "trail") this.robot(value.robot).trail =
      {x: value.points.map(each => each[0]), y: value.points.map(each => each[1]), count: value.points.length};
    else if (kind === "said") this.hear(value);
    else if (kind === "world") Object.assign(this, {world: value, worlds: this.worlds + 1});
    else if (["hello", "origins", "cans", "goals"].includes(kind)) this[kind] = value;
  }

  // A recording went back before the first word of a kind.
  forget(kind, value) {
    if (kind === "status" || kind === "helm") this.robot(value.robot)[kind] = {};
    else this.take(kind, {robots: [], world: null, origins: {}, cans: [], goals: {}}[kind]);
  }

  takeRobots(infos) {
    const known = new Set(infos.map(info => info.robot));
    for (const number of [...this.all.keys()]) if (!known.has(number)) this.all.delete(number);
    for (const info of infos) this.robot(info.robot).info = info;
    this.list = infos.map(info => this.robot(info.robot)).sort((one, other) => one.number - other.number);
  }

  // The same words again are counted, not repeated.
  hear(said) {
    const last = this.log[this.log.length - 1];
    if (last && last.text === said.text && last.robot === said.robot) last.times++;
    else this.log.push({...said, times: 1});
    if (this.log.length > 100) this.log.shift();
  }

  // Where the odometry of a robot begins in the map.
  origin(number) {
    const [x, y, heading] = this.origins[number] || [0, 0, 0];
    return {x, y, heading};
  }

  pose(robot) {
    const origin = this.origin(robot.number), [x, y] = place(origin, robot.frame.x, robot.frame.y);
    return {x, y, heading: origin.heading + robot.frame.heading};
  }

  // What the picture must show at least: the map, or all robots and some room around them.
  bounds() {
    if (this.world) return this.world.bounds;
    const places = this.list.filter(robot => robot.frame).map(robot => this.pose(robot));
    const xs = places.map(each => each.x), ys = places.map(each => each.y), room = 2.5;
    return places.length ? [Math.min(...xs) - room, Math.min(...ys) - room, Math.max(...xs) + room, Math.max(...ys) + room]
      : [-room, -room, room, room];
  }
}

// How a robot is, in a word: [class of the colour, sign, word]. The worst comes first.
export function stateOf(robot) {
  const link = robot.status.link;
  if (!robot.frame || !robot.is(FLAG.link) || (link !== undefined && link !== "ok")) return ["none", "?", "no link"];
  if (robot.is(FLAG.button)) return ["bad", "■", "STOP button"];
  if (robot.locked) return ["bad", "■", "stopped"];
  if (robot.is(FLAG.stallLeft | FLAG.stallRight)) return ["bad", "!", "stalled"];
  if (robot.is(FLAG.bumpFront | FLAG.bumpRear)) return ["bad", "!", "bumped"];
  if (robot.faults.some(fault => fault.level === "error")) return ["bad", "!", "fault"];
  const who = robot.helm.commander;
  if (who === "person") return ["person", "◆", robot.helm.who || "a person"];
  if (who === "program") return ["program", "▶", "program"];
  return robot.is(FLAG.motors) ? ["still", "●", "stands"] : ["still", "○", "motors off"];
}
