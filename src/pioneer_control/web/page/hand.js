// What a hand on keys, stick or gamepad wants, and when a robot is told. No events and no clock: both are given.

const KEYS = {ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0], ArrowLeft: [0, 1], KeyA: [0, 1], ArrowRight: [0, -1],
	KeyD: [0, -1]};
const REPEAT = 1000;	// ms: a key that is held repeats sooner than this
const FRESH = 400;		// ms: nobody drives by an older picture
const EVERY = 50;		// ms between two messages

export class Hand {
	held = new Map(); lost = new Map(); blocked = false;

	press(code, repeat, now) {
		// Held since the window lost the focus: some systems call its repeats new presses.
		if (this.lost.has(code) && (repeat || now <= this.lost.get(code))) this.lost.set(code, now + REPEAT);
		else if (code in KEYS && !repeat) {
			this.lost.delete(code);
			this.put(code, KEYS[code]);
		}
		return code in KEYS;
	}

	release(code) {
		this.lost.delete(code);
		this.put(code, null);
	}

	// A key, "stick" or "pad" is at [forward, turn], each -1 to 1; null: let go.
	put(what, at) {
		if (at) this.held.set(what, at); else this.held.delete(what);
		this.blocked &&= this.held.size > 0;
	}

	drop() {
		this.blocked = this.held.size > 0;
	}

	// The window lost the focus: no release of a key will be heard.
	leave() {
		for (const code of this.held.keys()) if (code in KEYS) {
			this.lost.set(code, Infinity);
			this.held.delete(code);
		}
		this.drop();
	}

	back(now) {
		for (const code of this.lost.keys()) this.lost.set(code, now + REPEAT);
	}

	wants() {
		if (this.blocked || !this.held.size) return null;
		return [0, 1].map(axis => Math.max(-1, Math.min(1, [...this.held.values()].reduce((sum, each) => sum + each[axis], 0))));
	}
}

// What a stick means that is moved so far to the right and down, in parts of its radius. Its middle is dead.
export function stickAt(dx, dy) {
	const far = Math.hypot(dx, dy), part = far && Math.min(1, Math.max(0, (far - 0.1) / 0.9)) / far;
	return [0 - dy * part, 0 - dx * part];
}

// Of gamepads: is there any, the stick of the first whose shoulder button (4 to 7) is held, is any B (1) pressed.
export function readPads(pads) {
	const all = [...pads].filter(pad => pad && pad.connected !== false), held = all.find(pad => pad.buttons.slice(4, 8).some(each => each.pressed));
	return {any: all.length > 0, stick: held ? stickAt(held.axes[0], held.axes[1]) : null, stop: all.some(pad => pad.buttons[1]?.pressed)};
}

// Tells a robot what the hand wants: only right after a picture was drawn, and only while that picture is fresh.
export class Deadman {
	robot = null; stamp = 0; at = -Infinity;

	constructor(send) {
		this.send = send;
	}

	// The newest frame of this robot that was drawn has this stamp, and was sent at that time (ms, our clock).
	drawn(want, robot, stamp, sent, now) {
		if (this.robot === robot) this.stamp = stamp;
		if (!want || this.robot !== null && this.robot !== robot) this.letGo();
		if (!want || now - sent > FRESH || now - this.at < EVERY) return;
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
