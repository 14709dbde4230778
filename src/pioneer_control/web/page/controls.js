// Listens to keys, stick and gamepad, and to all that takes the hand away. What it means, the hand knows.

import {drives, readPads, stickAt} from "./hand.js";
import {$} from "./panel.js";

export class Controls {
	// on: {stop(), gone(): the hand is gone, zero at once, key(name): another key}
	constructor(hand, on) {
		Object.assign(this, {hand, on, pointer: null, padStop: false});
		window.addEventListener("keydown", event => this.down(event), true);
		window.addEventListener("keyup", event => {
			if (isSpace(event)) return;
			hand.release(event.code);
			this.checkGone();
		}, true);
		this.listenStick($("stick"));
		for (const name of ["blur", "pagehide"]) window.addEventListener(name, () => this.leave());
		for (const name of ["visibilitychange", "freeze"]) document.addEventListener(name, () => this.leave());
		window.addEventListener("focus", () => hand.back(performance.now()));
		window.addEventListener("gamepaddisconnected", () => this.drop());
		document.addEventListener("focusin", event => writes(event.target) && this.drop());
	}

	// What is held counts no more until it is let go.
	drop() {
		this.hand.drop();
		this.freeStick();
		this.on.gone();
	}

	// The same where no release will be heard.
	leave() {
		this.hand.leave();
		this.drop();
	}

	checkGone() {
		if (!this.hand.held) this.on.gone();
	}

	down(event) {
		if (isSpace(event)) return event.repeat || this.on.stop();
		if (event.ctrlKey || event.altKey || event.metaKey || writes(event.target) || $("help").open) return;
		if (drives(event.code) && event.target !== $("line")) {
			event.preventDefault();
			this.hand.press(event.code, event.repeat, performance.now());
		} else this.on.key(event.key);
	}

	listenStick(stick) {
		const move = event => {
			if (event.pointerId !== this.pointer) return;
			const box = stick.getBoundingClientRect(), radius = 0.36 * box.width;
			const dx = (event.clientX - box.left - box.width / 2) / radius, dy = (event.clientY - box.top - box.height / 2) / radius;
			const shown = radius / Math.max(1, Math.hypot(dx, dy));
			$("knob").style.transform = `translate(${dx * shown}px, ${dy * shown}px)`;
			this.hand.put("stick", stickAt(dx, dy));
		};
		stick.onpointerdown = event => {
			if (this.pointer !== null || event.button) return;
			this.pointer = event.pointerId;
			stick.setPointerCapture(event.pointerId);
			move(event);
		};
		stick.onpointermove = move;
		stick.onpointerup = stick.onpointercancel = stick.onlostpointercapture = event => {
			if (event.pointerId !== this.pointer) return;
			this.freeStick();
			this.checkGone();
		};
		stick.oncontextmenu = event => event.preventDefault();
	}

	// A finger that is still there must come down anew.
	freeStick() {
		this.pointer = null;
		$("knob").style.transform = "";
		this.hand.put("stick", null);
	}

	// For each picture: gamepads tell nothing by themselves.
	poll() {
		const pads = readPads(navigator.getGamepads?.() || []), {held} = this.hand;
		if (pads.stop && !this.padStop) this.on.stop();
		this.padStop = pads.stop;
		if (!document.hasFocus()) return;		// as when the focus went: the shoulder button must be let go first
		this.hand.put("pad", pads.stick);
		if (held) this.checkGone();
	}
}

// The space bar comes first, whatever has the focus. Its release would press a button.
function isSpace(event) {
	if (event.code !== "Space") return false;
	event.preventDefault();
	event.stopImmediatePropagation();
	return true;
}

function writes(element) {
	return element instanceof HTMLElement && element.matches("input:not([type=range]), select");
}
