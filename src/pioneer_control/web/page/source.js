// The live connection: how old a message is, and which picture was drawn.

import {decodeFrames} from "./frames.js";

const FIRST_WAIT = 300, LONGEST_WAIT = 2000, BUSY_WAIT = 5000, PING = 1000, SILENCE = 5000, ACKNOWLEDGE = 100;		// ms
const DRIFT = 0.001;	// more than two clocks drift apart

// When a frame was sent, on our clock, from its stamp (u32, ms): the quickest frame tells how the clocks differ.
// So a frame that was held up on its way counts as old, although it arrived just now.
export class Clock {
	rounds = []; quickest = null; at = 0;

	sent(stamp, now) {
		this.quickest = this.quickest === null ? now - stamp : this.quickest + (now - this.at) * DRIFT;
		const late = now - stamp - this.quickest, held = late - 2 ** 32 * Math.round(late / 2 ** 32);
		this.quickest += Math.min(0, held);
		this.at = now;
		return now - Math.max(0, held) - (this.rounds.length && Math.min(...this.rounds.slice(-10)) / 2);
	}
}

export class Live {
	// on: {text(kind, value), frames([[frame, sent]]), recorded(buffer), state(name, reason)}
	constructor(url, words, on) {
		Object.assign(this, {url, words, on, wait: FIRST_WAIT, toldAt: 0});
		setInterval(() => this.tick(), PING);
		this.connect();
	}

	get open() {
		return this.greeted && this.socket?.readyState === 1;
	}

	connect() {
		const socket = new WebSocket(this.url);
		Object.assign(this, {socket, greeted: false, clock: new Clock(), newest: null, told: null, heard: performance.now()});
		this.on.state("connecting");
		socket.binaryType = "arraybuffer";
		socket.onopen = () => socket.send(JSON.stringify(this.words));
		socket.onmessage = event => socket === this.socket && this.take(event.data, performance.now());
		socket.onclose = event => socket === this.socket && this.closed(event.code, event.reason);
	}

	closed(code, reason) {
		this.socket = null;
		const refused = {4400: "refused", 4401: "no key"}[code];
		this.on.state(refused || "no connection", reason);
		if (refused) return;
		setTimeout(() => this.connect(), code === 4409 || code === 4429 ? BUSY_WAIT : this.wait);
		this.wait = Math.min(LONGEST_WAIT, 2 * this.wait);
	}

	take(data, now) {
		this.heard = now;
		if (typeof data !== "string") {
			if (new Uint8Array(data)[0] !== 1) return this.on.recorded(data);
			const frames = decodeFrames(data).map(frame => [frame, this.clock.sent(frame.stamp, now)]);
			this.newest = frames.at(-1)?.[0].stamp ?? this.newest;
			return this.on.frames(frames);
		}
		for (const [kind, value] of Object.entries(JSON.parse(data))) {
			if (kind === "pong") this.clock.rounds.push(now - value);
			else this.on.text(kind, value);
			if (kind === "hello") this.greet();
		}
	}

	greet() {
		this.greeted = true;
		this.wait = FIRST_WAIT;
		this.on.state("live");
		this.tick();
	}

	tick() {
		const {socket} = this, now = performance.now();
		if (!socket || now - this.heard < SILENCE) return this.send({do: "ping", at: now});
		this.closed(1006);
		socket.close();
	}

	send(message) {
		if (this.open) this.socket.send(JSON.stringify(message));
		return this.open;
	}

	// All that came was drawn. The last batch is always acknowledged, or the server waits for ever.
	drawn(now) {
		if (this.newest === this.told || now - this.toldAt < ACKNOWLEDGE) return;
		if (this.send({do: "drawn", stamp: this.newest})) Object.assign(this, {told: this.newest, toldAt: now});
	}
}
