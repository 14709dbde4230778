// Listens to keys, stick and gamepad, and to all that takes the hand away. What it means, the hand knows.

import {readPads, stickAt} from "./hand.js";
import {$} from "./panel.js";

// The space bar comes first, whatever has the focus. Its release would press a button.
function isSpace(event) {
	if (event.code !== "Space") return false;
	event.preventDefault();
	event.stopImmediatePropagation();
	return true;
}

function writes(element) {
	return element.matches?.("input:not([type=range]), select");
}

// on: {stop(), gone(): the hand is gone, zero at once, key(name): another key}
export function listenHand(hand, on) {
	const stick = $("stick");
	let pointer = null, padStop = false;

	function checkGone() {
		if (!hand.held.size) on.gone();
	}

	// A finger that is still there must come down anew.
	function freeStick() {
		pointer = null;
		$("knob").style.transform = "";
		hand.put("stick", null);
	}

	function drop() {
		hand.drop();
		freeStick();
		on.gone();
	}

	function poll() {
		const pads = readPads(navigator.getGamepads?.() || []), {size} = hand.held;
		if (pads.stop && !padStop) on.stop();
		padStop = pads.stop;
		if (!document.hasFocus()) return;		// as when the focus went: the shoulder button must be let go first
		hand.put("pad", pads.stick);
		if (size) checkGone();
		return pads.any;
	}

	addEventListener("keydown", event => {
		const {code, key, repeat, target} = event;
		if (isSpace(event)) return repeat || on.stop();
		if (event.ctrlKey || event.altKey || event.metaKey || writes(target) || document.querySelector("dialog[open]")) return;
		if (target !== $("line") && hand.press(code, repeat, performance.now())) event.preventDefault();
		else on.key(key);
	}, true);
	addEventListener("keyup", event => {
		if (isSpace(event)) return;
		hand.release(event.code);
		checkGone();
	}, true);
	for (const name of ["blur", "pagehide", "visibilitychange", "freeze"]) for (const where of [window, document])
		where.addEventListener(name, () => {
			hand.leave();
			drop();
		});
	addEventListener("focus", () => hand.back(performance.now()));
	addEventListener("gamepaddisconnected", drop);
	addEventListener("focusin", event => writes(event.target) && drop());

	stick.onpointermove = event => {
		if (event.pointerId !== pointer) return;
		const {left, top, width} = stick.getBoundingClientRect(), radius = 0.36 * width;
		const dx = (event.clientX - left - width / 2) / radius, dy = (event.clientY - top - width / 2) / radius;
		const shown = radius / Math.max(1, Math.hypot(dx, dy));
		$("knob").style.transform = `translate(${dx * shown}px, ${dy * shown}px)`;
		hand.put("stick", stickAt(dx, dy));
	};
	stick.onpointerdown = event => {
		if (pointer !== null || event.button) return;
		pointer = event.pointerId;
		stick.setPointerCapture(pointer);
		stick.onpointermove(event);
	};
	stick.onpointerup = stick.onpointercancel = stick.onlostpointercapture = event => {
		if (event.pointerId !== pointer) return;
		freeStick();
		checkGone();
	};
	stick.oncontextmenu = event => event.preventDefault();
	return {drop, poll};
}
