// The live connection: first words, reconnecting, how long messages are on their way, and which picture was drawn.

import {decodeFrames} from "./frames.js";

const FIRST_WAIT = 300, LONGEST_WAIT = 2000, BUSY_WAIT = 5000;      // ms before the next try
const PING = 1000, SILENCE = 5000, ACKNOWLEDGE = 100;               // ms

// The server's clock, from stamps (u32, ms): on ours, each frame was sent when the quickest ones say.
// So a frame that waited on its way counts as old, although it arrived just now.
export class Clock {
  constructor() {
    Object.assign(this, {rounds: [], least: [Infinity, Infinity], turned: -Infinity, base: null});
  }

  ponged(round) {
    this.rounds = [...this.rounds.slice(-9), round];
  }

  get transit() {
    return this.rounds.length ? Math.min(...this.rounds) / 2 : 0;
  }

  // Returns when a frame that arrives now was sent, in ms of our clock.
  sent(stamp, now) {
    if (this.base === null) this.base = now - stamp;
    let late = (now - stamp - this.base) % 2 ** 32;         // against the first frame
    if (late > 2 ** 31) late -= 2 ** 32; else if (late < -(2 ** 31)) late += 2 ** 32;
    if (now - this.turned > 30000) {                        // quickest of the last half to whole minute: clocks drift
      this.least = [Infinity, this.least[0]];
      this.turned = now;
    }
    this.least[0] = Math.min(this.least[0], late);
    return now - (late - Math.min(...this.least)) - this.transit;
  }
}

export class Live {
  // on: {text(kind, value), frames(list of [frame, sent]), state("connecting" | "open" | "closed", reason)}
  constructor(url, words, on) {
    Object.assign(this, {url, words, on, socket: null, wait: FIRST_WAIT, heard: 0, newest: null, told: null, toldAt: 0});
    setInterval(() => this.tick(), PING);
    this.connect();
  }

  get open() {
    return this.socket !== null && this.greeted && this.socket.readyState === WebSocket.OPEN;
  }

  connect() {
    const socket = new WebSocket(this.url);
    Object.assign(this, {socket, greeted: false, clock: new Clock(), newest: null, told: null, heard: performance.now()});
    this.on.state("connecting", "");
    socket.binaryType = "arraybuffer";
    socket.onopen = () => socket.send(JSON.stringify(this.words));
    socket.onmessage = event => socket === this.socket && this.take(event.data);
    socket.onclose = event => socket === this.socket && this.closed(event.code, event.reason);
  }

  closed(code, reason) {
    const final = code === 4400 || code === 4401;
    this.socket = null;
    this.on.state(code === 4401 ? "key" : final ? "refused" : "closed", reason);
    if (final) return;
    setTimeout(() => this.connect(), code === 4429 ? BUSY_WAIT : this.wait);
    this.wait = Math.min(LONGEST_WAIT, 2 * this.wait);
  }

  take(data) {
    const now = performance.now();
    this.heard = now;
    if (typeof data !== "string") {
      if (new Uint8Array(data)[0] === 1) {
        const frames = decodeFrames(data);
        for (const frame of frames) this.newest = frame.stamp;
        this.on.frames(frames.map(frame => [frame, this.clock.sent(frame.stamp, now)]));
      } else this.on.columns(data);
      return;
    }
    for (const [kind, value] of Object.entries(JSON.parse(data))) {
      if (kind === "pong") this.clock.ponged(now - value);
      else {
        if (kind === "hello") this.greet(value);
        this.on.text(kind, value);
      }
    }
  }

  greet() {
    this.greeted = true;
    this.wait = FIRST_WAIT;
    this.on.state("open", "");
    this.tick();
  }

  // A network that went dark tells nothing: after some silence, ours is the end.
  tick() {
    if (!this.socket) return;
    const now = performance.now();
    if (now - this.heard > SILENCE) {
      const {socket} = this;
      this.closed(1006, "nothing was heard");
      socket.close();
    } else this.send({do: "ping", at: now});
  }

  // Tells whether it went out.
  send(message) {
    if (this.open) this.socket.send(JSON.stringify(message));
    return this.open;
  }

  // A picture was drawn with all that came: the last batch is always acknowledged, or the server waits for ever.
  drawn(now) {
    if (this.newest === this.told || now - this.toldAt < ACKNOWLEDGE) return;
    if (this.send({do: "drawn", stamp: this.newest})) Object.assign(this, {told: this.newest, toldAt: now});
  }
}
