// What a hand on keys, stick or gamepad wants, and when a robot is told. No events and no clock: both are given.

const KEYS = {ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0], ArrowLeft: [0, 1], KeyA: [0, 1], ArrowRight: [0, -1],
	KeyD: [0, -1]};
const REPEAT = 1000;	// ms: a key that is held repeats sooner than this
const FRESH = 400;		// ms: nobody drives by an older picture
const EVERY = 50;		// ms between two messages

export function drives(code) {
	return Object.hasOwn(KEYS, code);
}

export class Hand {
	constructor() {
		Object.assign(this, {keys: new Set(), lost: new Map(), stick: null, pad: null, blocked: false});
	}

	press(code, repeat, now) {
		if (this.lost.has(code)) {		// held since the window lost the focus: some systems call its repeats new presses
			if (repeat || now <= this.lost.get(code)) return void this.lost.set(code, now + REPEAT);
			this.lost.delete(code);
		}
		if (!repeat && drives(code)) this.keys.add(code);
	}

	release(code) {
		this.keys.delete(code);
		this.lost.delete(code);
		this.settle();
	}

	// "stick" or "pad" is at [forward, turn], each -1 to 1; null: let go.
	put(what, at) {
		this[what] = at;
		this.settle();
	}

	get held() {
		return this.keys.size > 0 || this.stick !== null || this.pad !== null;
	}

	settle() {
		if (!this.held) this.blocked = false;
	}

	// Nothing counts until all is let go.
	drop() {
		this.blocked = this.held;
	}

	// The window lost the focus: no release of a key will be heard.
	leave() {
		for (const code of this.keys) this.lost.set(code, Infinity);
		this.keys.clear();
		this.drop();
	}

	back(now) {
		for (const code of this.lost.keys()) this.lost.set(code, now + REPEAT);
	}

	// [forward, turn], or null: the hand is off.
	wants() {
		if (!this.held || this.blocked) return null;
		const all = [this.stick || this.pad || [0, 0], ...[...this.keys].map(code => KEYS[code])];
		return [0, 1].map(axis => Math.max(-1, Math.min(1, all.reduce((sum, each) => sum + each[axis], 0))));
	}
}

// What a stick means that is moved so far to the right and down, in parts of its radius. Its middle is dead.
export function stickAt(dx, dy) {
	const far = Math.hypot(dx, dy), part = far ? Math.min(1, Math.max(0, (far - 0.1) / 0.9)) / far : 0;
	return [0 - dy * part, 0 - dx * part];
}

// Of gamepads: the stick of the first whose shoulder button (4 to 7) is held, and whether any B (1) is pressed.
export function readPads(pads) {
	const all = [...pads].filter(pad => pad && pad.connected !== false);
	const pressed = (pad, numbers) => numbers.some(number => pad.buttons[number] && pad.buttons[number].pressed);
	const held = all.find(pad => pressed(pad, [4, 5, 6, 7]));
	return {stick: held ? stickAt(held.axes[0], held.axes[1]) : null, stop: all.some(pad => pressed(pad, [1]))};
}

// Tells a robot what the hand wants: only right after a picture was drawn, and only while that picture is fresh.
export class Deadman {
	constructor(send) {
		Object.assign(this, {send, robot: null, stamp: 0, at: -Infinity});
	}

	// A picture was drawn: the newest frame in it of this robot has this stamp, and was sent at that time (ms, our clock).
	drawn(want, robot, stamp, sent, now) {
		if (this.robot === robot) this.stamp = stamp;
		if (want === null || this.robot !== null && this.robot !== robot) this.letGo();
		if (want === null || now - sent > FRESH || now - this.at < EVERY) return;
		Object.assign(this, {robot, stamp, at: now});
		this.send({do: "drive", robot, forward: want[0], turn: want[1], stamp});
	}

	// The hand is gone: zero, at once and once.
	letGo() {
		const {robot, stamp} = this;
		this.robot = null;
		if (robot !== null) this.send({do: "drive", robot, forward: 0, turn: 0, stamp});
	}
}
