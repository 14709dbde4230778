// The words beside the map: the chosen robot, the list of all, what the server said. Only ever as texts, never as markup.

import {FLAG, GRIP} from "./frames.js";
import {stateOf} from "./model.js";

export function $(id) {
	return document.getElementById(id);
}

// Changes only what is not yet so: a screen reader speaks only of what changed. The style sheet hides paragraphs without words.
export function put(element, text = "", kind = "") {
	if (typeof element === "string") element = $(element);
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

// The words of a table whose bits are set.
function named(bits, words, none) {
	return Object.keys(words).filter(word => bits & words[word]).join(", ") || none;
}

// The numbers: title, what is so, and the level where it is bad.
const NUMBERS = {
	linear: ["Forward", ({frame}) => frame.linear.toFixed(2) + " m/s"],
	angular: ["Turn", ({frame}) => turnText(Math.round(frame.angular * 180 / Math.PI))],
	battery: ["Battery", batteryText, ({status: {battery}}) => battery?.level],
	motors: ["Motors", robot => robot.is(FLAG.motors) ? "on" : "off"],
	wheels: flagged("Wheels", {"left stalled": FLAG.stallLeft, "right stalled": FLAG.stallRight}),
	bumpers: flagged("Bumpers", {"front pressed": FLAG.bumpFront, "rear pressed": FLAG.bumpRear}),
	button: flagged("STOP button", {pressed: FLAG.button}),
	gripper: ["Gripper", ({frame}) => named(frame.gripper, GRIP, "half open")],
	link: ["Link", linkText, ({status: {link}}) => link === "ok" ? "" : "error"],
};

function flagged(title, words) {
	const say = ({frame}) => named(frame.flags, words, "free");
	return [title, say, robot => say(robot) === "free" ? "" : "error"];
}

function turnText(degrees) {
	return Math.abs(degrees) + " °/s" + (degrees > 0 ? " left" : degrees ? " right" : "");
}

function batteryText(robot) {
	const {volts, charge, level} = robot.status.battery || {}, word = {warn: "low", error: "empty"}[level];
	return volts ? [`${volts.toFixed(1)} V`, typeof charge === "number" && `${Math.round(100 * charge)} %`, word,
		robot.is(FLAG.charging) && "charging"].filter(Boolean).join(" · ") : "not known";
}

function linkText({status: {link, lost, counts}}) {
	return link !== "ok" ? link + (lost ? ": " + lost : "") : `works, ${Math.round(counts.sips_per_second || 0)} packets/s, ` +
		`${counts.bad_checksums || "none"} damaged, ${counts.reconnects || "no"} reconnects`;
}

// Who drives: sign, words, and what may be done about it.
function driver({locked, helm: {commander, who, you, programs, locks}}) {
	const others = {free: "Programs may command.", "locked out": "Programs are locked out."}[programs];
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
		for (const [id, [title]] of Object.entries(NUMBERS)) {
			const cell = make($("numbers"), "div");
			make(cell, "dt", title);
			make(cell, "dd", "", {id});
		}
	}

	update({list, log}, robot, live) {
		this.updateList(list, robot);
		items($("log-list"), log.slice(-8), (item, said) => put(item, (said.robot ? said.robot + ": " : "") + said.text +
			(said.times > 1 ? ` (${said.times} times)` : ""), said.level));
		document.body.classList.toggle("empty", !robot);
		if (robot) this.updateRobot(robot, live, live && robot.info.yours !== false);
	}

	updateRobot(robot, live, mine) {
		const {number, info, frame, helm: {locks, programs, limit}, status: {decision, faults}} = robot, locked = locks.length > 0;
		const [sign, words, note] = driver(robot), gripper = frame?.gripper > 0, motors = robot.is(FLAG.motors);
		const texts = {number: String(number), name: info.name, model: info.model + (info.simulated ? " · simulated" : ""),
			"driver-sign": sign, "driver-text": words, "driver-note": !live ? "" : mine ? note : "You may look, but not drive this one.",
			doing: decision?.doing, why: decision?.why && "because " + decision.why, "limit-text": limit[0].toFixed(2) + " m/s",
			"motors-switch": motors ? "Switch motors off" : "Switch motors on",
			hint: !mine ? "look only" : robot.locked ? "locked: unlock above" : !motors ? "motors are off" :
				programs === "driving" ? "a program drives" : "hold arrows or stick"};
		for (const [id, text] of Object.entries(texts)) put(id, text);
		const shown = {unlock: mine && locked, take: mine && !locked && ["driving", "free"].includes(programs),
			release: mine && !locked && programs === "locked out", decision, controls: mine, grip: gripper};
		for (const [id, is] of Object.entries(shown)) show(id, is);
		$("helm").dataset.kind = stateOf(robot)[0];
		items($("faults"), faults, (item, {level, task, text}) => put(item, `${level === "error" ? "✖" : "▲"} ${task}: ${text}`, level));
		for (const [id, [, say, levelOf]] of Object.entries(NUMBERS)) {
			const known = frame || id === "link";
			put(id, known ? say(robot) : "–", known && levelOf?.(robot) || "");
		}
		$("gripper").parentNode.hidden = !gripper;
	}

	updateList(list, chosen) {
		show("list", list.length > 1 || !$("teacher").hidden);
		show("steps", list.length > 1);
		items($("tiles"), list.map(robot => robot.number), (item, number) => {
			const button = make(item, "button", "", {onclick: () => this.choose(number)});
			this.tiles.set(number, [button, ...["number", "sign", "state", "note"].map(className => make(button, "span", "", {className}))]);
		});
		for (const robot of list) {
			const [button, ...parts] = this.tiles.get(robot.number), [kind, sign, word] = stateOf(robot), pressed = String(robot === chosen);
			const {status: {battery}, helm: {who, commander}} = robot, drives = (kind === "bad" || kind === "none") && (who || commander);
			const volts = battery && (battery.level === "ok" ? "" : "low ") + battery.volts.toFixed(1) + " V";
			[String(robot.number), sign, word, [volts, drives].filter(Boolean).join(" · ")].forEach((text, i) => put(parts[i], text));
			button.dataset.kind = kind;
			if (button.ariaPressed === pressed) continue;
			button.ariaPressed = pressed;
			if (robot === chosen) button.scrollIntoView({block: "nearest", inline: "nearest"});
		}
	}
}
