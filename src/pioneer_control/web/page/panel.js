// The words beside the map: the chosen robot, the list of all, what the server said. Only ever as texts, never as markup.

import {FLAG, GRIP} from "./frames.js";
import {stateOf} from "./model.js";

export function $(id) {
	return document.getElementById(id);
}

// Changes only what is not yet so: a screen reader speaks only of what changed.
export function put(id, text, kind = "") {
	const element = typeof id === "string" ? $(id) : id;
	if (element.textContent !== text) element.textContent = text;
	if (element.dataset.kind !== kind) element.dataset.kind = kind;
}

export function show(id, shown) {
	$(id).hidden = !shown;
}

export function make(parent, tag, text = "", more = {}) {
	const element = Object.assign(document.createElement(tag), {textContent: text, ...more});
	parent.append(element);
	return element;
}

// Fills a list with an item for each value, if the values are others than before.
export function items(list, values, fill) {
	const key = JSON.stringify(values);
	if (list.dataset.key === key) return;
	list.dataset.key = key;
	list.replaceChildren();
	for (const value of values) fill(make(list, "li"), value);
}

// The numbers: title, what is so, and whether that is bad (true, or a level).
const CELLS = {
	linear: ["Forward", ({frame}) => frame.linear.toFixed(2) + " m/s"],
	angular: ["Turn", ({frame}) => turnText(Math.round(frame.angular * 180 / Math.PI))],
	battery: ["Battery", robot => batteryText(robot.status.battery || {}) + (robot.is(FLAG.charging) ? " · charging" : ""),
		({status: {battery}}) => battery && battery.level],
	motors: ["Motors", robot => robot.is(FLAG.motors) ? "on" : "off"],
	wheels: ["Wheels", robot => both(robot, FLAG.stallLeft, "left", FLAG.stallRight, "right", " stalled"), robot => robot.is(FLAG.stall)],
	bumpers: ["Bumpers", robot => both(robot, FLAG.bumpFront, "front", FLAG.bumpRear, "rear", " pressed"), robot => robot.is(FLAG.bump)],
	button: ["STOP button", robot => robot.is(FLAG.button) ? "pressed" : "free", robot => robot.is(FLAG.button)],
	gripper: ["Gripper", ({frame}) => gripText(frame.gripper)],
	link: ["Link", ({status}) => linkText(status), ({status: {link = "ok"}}) => link !== "ok"],
};

function turnText(degrees) {
	return Math.abs(degrees) + " °/s" + (degrees > 0 ? " left" : degrees ? " right" : "");
}

function both(robot, one, oneWord, other, otherWord, what) {
	return [robot.is(one) && oneWord, robot.is(other) && otherWord].filter(Boolean).join(" and ").replace(/$/, what).replace(/^ .*/, "free");
}

function batteryText({volts, charge, level}) {
	return volts === undefined ? "not known" : `${volts.toFixed(1)} V` + (typeof charge === "number" ? ` · ${Math.round(100 * charge)} %` : "") +
		({warn: " · low", error: " · empty"}[level] || "");
}

function gripText(state) {
	const words = {moving: "moving", open: "open", closed: "closed", lifting: "lift moving", up: "up", down: "down", holding: "holds something"};
	return Object.keys(words).filter(name => state & GRIP[name]).map(name => words[name]).join(", ") || "half open";
}

function linkText({link = "ok", lost, counts: {sips_per_second: packets = 0, bad_checksums: damaged, reconnects} = {}}) {
	return link === "ok" ? `works, ${Math.round(packets)} packets/s, ${damaged || "none"} damaged, ${reconnects || "no"} reconnects` :
		link + (lost ? ": " + lost : "");
}

// Who drives: sign, words, and what may be done about it.
function driver({locked, helm: {commander, who, you, programs, locks = []}}) {
	const others = {free: "Programs may command.", "locked out": "Programs are locked out."}[programs] || "";
	return locked ? ["■", "Locked: " + (locks.join(", ") || "it takes no commands"), "Nothing moves until somebody unlocks."] :
		commander === "person" ? ["◆", you ? "You drive" : `${who || "Somebody"} drives`, others] :
			commander === "program" ? ["▶", "A program drives", "Take the helm to drive by hand."] : ["○", "Nobody drives", others];
}

export class Panel {
	// choose(number) is called for a click in the list, grip(command) for a button of the gripper.
	constructor(choose, grip) {
		Object.assign(this, {choose, tiles: new Map()});
		for (const command of ["open", "close", "up", "down", "deploy", "store", "stop"])
			make($("grip"), "button", command === "stop" ? "halt" : command).onclick = () => grip(command);
		for (const [id, [title]] of Object.entries(CELLS)) {
			const cell = make($("numbers"), "div");
			make(cell, "dt", title);
			make(cell, "dd", "", {id});
		}
	}

	update(model, robot, live) {
		this.updateList(model, robot);
		items($("log-list"), model.log.slice(-8), (item, said) => put(item, (said.robot ? said.robot + ": " : "") + said.text +
			(said.times > 1 ? ` (${said.times} times)` : ""), said.level));
		document.body.classList.toggle("empty", !robot);
		if (robot) this.updateRobot(robot, live, live && robot.info.yours !== false);
	}

	updateRobot(robot, live, mine) {
		const {number, info, frame, helm: {locks = [], programs, limit}, status: {decision, faults}} = robot, locked = locks.length > 0;
		const [sign, words, note] = driver(robot), gripper = frame && frame.gripper > 0, motors = robot.is(FLAG.motors);
		const texts = {number: String(number), name: info.name, model: [info.model, info.simulated && "simulated"].filter(Boolean).join(" · "),
			"driver-sign": sign, "driver-text": words, "driver-note": !live ? "" : mine ? note : "You may look, but not drive this one.",
			doing: decision ? decision.doing : "", why: decision && decision.why ? "because " + decision.why : "",
			"limit-text": limit ? limit[0].toFixed(2) + " m/s" : "–", "motors-switch": motors ? "Switch motors off" : "Switch motors on",
			hint: !mine ? "look only" : robot.locked ? "locked: unlock above" : !motors ? "motors are off" :
				programs === "driving" ? "a program drives" : "hold arrows or stick"};
		for (const [id, text] of Object.entries(texts)) put(id, text);
		const shown = {unlock: mine && locked, take: mine && !locked && ["driving", "free"].includes(programs),
			release: mine && !locked && programs === "locked out", decision, controls: mine, grip: gripper};
		for (const [id, is] of Object.entries(shown)) show(id, is);
		$("helm").dataset.kind = stateOf(robot)[0];
		items($("faults"), faults || [], (item, {level, task, text}) => put(item, `${level === "error" ? "✖" : "▲"} ${task}: ${text}`, level));
		for (const [id, [, say, bad = () => ""]] of Object.entries(CELLS)) {
			const level = bad(robot);
			put(id, frame || id === "link" ? say(robot) : "–", level === true ? "error" : level || "");
		}
		$("gripper").parentNode.hidden = !gripper;
	}

	updateList({list}, chosen) {
		show("list", list.length > 1);
		show("previous", list.length > 1);
		show("next", list.length > 1);
		items($("tiles"), list.map(robot => robot.number), (item, number) => {
			const button = make(item, "button", "", {onclick: () => this.choose(number)});
			this.tiles.set(number, [button, ...["number", "sign", "state", "volts", "who"].map(className => make(button, "span", "", {className}))]);
		});
		for (const robot of list) {
			const [button, ...parts] = this.tiles.get(robot.number), [kind, sign, word] = stateOf(robot), {battery} = robot.status;
			const volts = battery ? (battery.level === "ok" ? "" : "low ") + battery.volts.toFixed(1) + " V" : "";
			const who = kind === "bad" || kind === "none" ? robot.helm.who || robot.helm.commander || "" : "", pressed = String(robot === chosen);
			[String(robot.number), sign, word, volts, who].forEach((text, i) => put(parts[i], text));
			button.dataset.kind = kind;
			if (button.ariaPressed === pressed) continue;
			button.ariaPressed = pressed;
			if (robot === chosen) button.scrollIntoView({block: "nearest", inline: "nearest"});
		}
	}
}
