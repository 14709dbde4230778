// Listens to keyboard, stick and gamepad, and to all that takes the hand away. The hand decides what it means.

import {drives, readPads, stickAt} from "./hand.js";
import {byId} from "./panel.js";

// on: {stop(), gone() the hand is gone: zero at once, key(name) another key}
export class Controls {
  constructor(hand, on) {
    Object.assign(this, {hand, on, pointer: null, padStop: false});
    this.listenKeys();
    this.listenStick();
    for (const name of ["blur", "pagehide", "freeze"]) window.addEventListener(name, () => this.leave());
    for (const name of ["visibilitychange", "freeze"])
      document.addEventListener(name, () => (document.hidden || name === "freeze") && this.leave());
    window.addEventListener("focus", () => hand.back(performance.now()));
    window.addEventListener("gamepaddisconnected", () => this.drop());
    document.addEventListener("focusin", event => writes(event.target) && this.drop());
  }

  // What is held counts no more until it was let go.
  drop() {
    this.hand.drop();
    this.freeStick();
    this.on.gone();
  }

  leave() {
    this.hand.leave();
    this.freeStick();
    this.on.gone();
  }

  listenKeys() {
    const swallow = event => {
      event.preventDefault();
      event.stopImmediatePropagation();
    };
    // The space bar comes first, whatever has the focus; its release would press a button.
    window.addEventListener("keydown", event => {
      if (event.code === "Space") {
        swallow(event);
        if (!event.repeat) this.on.stop();
        return;
      }
      if (event.ctrlKey || event.altKey || event.metaKey || writes(event.target) || byId("help").open) return;
      if (drives(event.code) && event.target !== byId("line")) {
        event.preventDefault();
        this.hand.press(event.code, event.repeat, performance.now());
      } else if (!event.repeat || "+-".includes(event.key)) this.on.key(event.key);
    }, true);
    window.addEventListener("keyup", event => {
      if (event.code === "Space") return swallow(event);
      this.hand.release(event.code);
      if (!this.hand.held) this.on.gone();
    }, true);
    window.addEventListener("keypress", event => event.code === "Space" && swallow(event), true);
  }

  listenStick() {
    const stick = byId("stick");
    const move = event => {
      if (event.pointerId !== this.pointer) return;
      const box = stick.getBoundingClientRect(), radius = box.width / 2 * 0.72;
      let dx = (event.clientX - box.left - box.width / 2) / radius, dy = (event.clientY - box.top - box.height / 2) / radius;
      const far = Math.max(1, Math.hypot(dx, dy));
      [dx, dy] = [dx / far, dy / far];
      this.hand.setStick(stickAt(dx, dy));
      byId("knob").style.transform = `translate(${dx * radius}px, ${dy * radius}px)`;
    };
    const gone = event => {
      if (event.pointerId !== this.pointer) return;
      this.freeStick();
      if (!this.hand.held) this.on.gone();
    };
    stick.addEventListener("pointerdown", event => {
      if (this.pointer !== null || event.button !== 0) return;
      this.pointer = event.pointerId;
      stick.setPointerCapture(event.pointerId);
      move(event);
    });
    stick.addEventListener("pointermove", move);
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) stick.addEventListener(name, gone);
    stick.addEventListener("contextmenu", event => event.preventDefault());
  }

  // The finger must come down anew.
  freeStick() {
    this.pointer = null;
    byId("knob").style.transform = "";
    this.hand.setStick(null);
  }

  // Asked for each picture: gamepads tell nothing by themselves.
  poll() {
    const pads = readPads(navigator.getGamepads ? navigator.getGamepads() : []), {held} = this.hand;
    if (pads.stop && !this.padStop) this.on.stop();
    this.padStop = pads.stop;
    if (!document.hasFocus()) return;       // as it was when the focus went: the shoulder button must be let go first
    this.hand.setPad(pads.drive);
    if (held && !this.hand.held) this.on.gone();
  }
}

function writes(element) {
  return element instanceof HTMLElement && (element.matches("input, textarea, select") || element.isContentEditable);
}
