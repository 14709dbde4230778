// The words beside the map: the chosen robot, the list of all, what the server said. Only ever as texts, never as markup.

import {FLAG, GRIP} from "./frames.js";
import {stateOf} from "./model.js";

export function byId(id) {
	return document.getElementById(id);
}

// Changes only what is not yet so: a screen reader speaks only of what changed.
export function put(id, text, kind = "") {
	const element = typeof id === "string" ? byId(id) : id;
	if (element.textContent !== text) element.textContent = text;
	if (element.dataset.kind !== kind) element.dataset.kind = kind;
}

export function show(id, shown) {
	byId(id).hidden = !shown;
}

// Fills a list with an item for each value, if the values are others than before.
export function items(list, values, make) {
	const key = JSON.stringify(values);
	if (list.dataset.key === key) return;
	list.dataset.key = key;
	list.replaceChildren(...values.map(value => {
		const item = document.createElement("li");
		make(item, value);
		return item;
	}));
}

// What the numbers show: title, what is so, and whether that is bad.
const CELLS = {
	linear: ["Forward", robot => `${robot.frame.linear.toFixed(2)} m/s`],
	angular: ["Turn", robot => turnText(Math.round(robot.frame.angular * 180 / Math.PI))],
	battery: ["Battery", robot => batteryText(robot.status.battery) + (robot.is(FLAG.charging) ? " · charging" : ""),
		robot => (robot.status.battery || {}).level],
	motors: ["Motors", robot => robot.is(FLAG.motors) ? "on" : "off"],
	wheels: ["Wheels", robot => either(robot, FLAG.stallLeft, "left", FLAG.stallRight, "right", " stalled"), robot => robot.is(FLAG.stall)],
	bumpers: ["Bumpers", robot => either(robot, FLAG.bumpFront, "front", FLAG.bumpRear, "rear", " pressed"), robot => robot.is(FLAG.bump)],
	button: ["STOP button", robot => robot.is(FLAG.button) ? "pressed" : "free", robot => robot.is(FLAG.button)],
	gripper: ["Gripper", robot => gripText(robot.frame.gripper)],
	link: ["Link", robot => linkText(robot.status.link || "ok", robot.status.counts), robot => (robot.status.link || "ok") !== "ok"],
};

function turnText(degrees) {
	return `${Math.abs(degrees)} °/s${degrees ? degrees > 0 ? " left" : " right" : ""}`;
}

function either(robot, one, oneWord, other, otherWord, what) {
	const words = [robot.is(one) && oneWord, robot.is(other) && otherWord].filter(Boolean);
	return words.length ? words.join(" and ") + what : "free";
}

function batteryText(battery) {
	if (!battery) return "not known";
	const {volts, charge, level} = battery;
	return `${volts.toFixed(1)} V${typeof charge === "number" ? ` · ${Math.round(100 * charge)} %` : ""}` +
		({warn: " · low", error: " · empty"}[level] || "");
}

function gripText(state) {
	const paddles = state & GRIP.moving ? "moving" : state & GRIP.open ? "open" : state & GRIP.closed ? "closed" : "half open";
	const lift = state & GRIP.lifting ? "lift moving" : state & GRIP.up ? "up" : state & GRIP.down ? "down" : "";
	return [paddles, lift, state & GRIP.holding && "holds something"].filter(Boolean).join(", ");
}

function linkText(link, counts) {
	return (link === "ok" ? "works" : link) + (counts ? `, ${Math.round(counts.sips_per_second)} packets/s, ${counts.bad_checksums} damaged, ` +
		`${counts.reconnects} reconnects` : "");
}

// Who drives: sign, words, and what may be done about it.
function driver(robot) {
	const {commander, who, you, programs, locks} = robot.helm;
	const others = {free: "Programs may command.", "locked out": "Programs are locked out."}[programs] || "";
	if (robot.locked) return ["■", "Locked: " + ((locks || []).join(", ") || "it takes no commands"), "Nothing moves until somebody unlocks."];
	if (commander === "person") return ["◆", you ? "You drive" : `${who || "Somebody"} drives`, others];
	if (commander === "program") return ["▶", "A program drives", "Take the helm to drive by hand."];
	return ["○", "Nobody drives", others];
}

export class Panel {
	// choose(number) is called for a click in the list, grip(command) for a button of the gripper.
	constructor(choose, grip) {
		Object.assign(this, {choose, tiles: new Map()});
		for (const command of ["open", "close", "up", "down", "deploy", "store", "stop"]) {
			const button = document.createElement("button");
			button.textContent = command;
			button.onclick = () => grip(command);
			byId("grip").append(button);
		}
		for (const [id, [title]] of Object.entries(CELLS)) {
			const cell = document.createElement("div"), parts = ["dt", "dd"].map(name => document.createElement(name));
			parts[0].textContent = title;
			parts[1].id = id;
			cell.append(...parts);
			byId("numbers").append(cell);
		}
	}

	update(model, robot, live) {
		this.updateList(model, robot);
		items(byId("log-list"), model.log.slice(-8), (item, said) => put(item, (said.robot ? said.robot + ": " : "") + said.text +
			(said.times > 1 ? ` (${said.times} times)` : ""), said.level));
		for (const id of ["previous", "next"]) show(id, model.list.length > 1);
		document.body.classList.toggle("empty", !robot);
		if (robot) this.updateRobot(robot, live, live && robot.info.yours !== false);
	}

	updateRobot(robot, live, mine) {
		const {info, frame, helm, status: {decision, faults}} = robot, [kind] = stateOf(robot), locked = (helm.locks || []).length > 0;
		put("number", String(robot.number));
		put("name", info.name);
		put("model", info.model + (info.simulated ? " · simulated" : ""));
		const [sign, words, note] = driver(robot);
		put("driver-sign", sign);
		put("driver-text", words);
		put("driver-note", !live ? "" : mine ? note : "You may look, but not drive this one.");
		byId("helm").dataset.kind = kind;
		show("unlock", mine && locked);
		show("take", mine && !locked && ["driving", "free"].includes(helm.programs));
		show("release", mine && !locked && helm.programs === "locked out");
		show("decision", decision);
		put("doing", decision ? decision.doing : "");
		put("why", decision && decision.why ? "because " + decision.why : "");
		items(byId("faults"), faults || [], (item, {level, task, text}) => put(item, `${level === "error" ? "✖" : "▲"} ${task}: ${text}`, level));
		show("controls", mine);
		put("limit-text", helm.limit ? `${helm.limit[0].toFixed(2)} m/s` : "–");
		for (const [id, [, say, bad]] of Object.entries(CELLS)) {
			const value = bad && bad(robot);
			put(id, frame || id === "link" ? say(robot) : "–", value === true ? "error" : value || "");
		}
		const gripper = frame && frame.gripper > 0, motors = robot.is(FLAG.motors);
		byId("gripper").parentNode.hidden = !gripper;
		show("grip", gripper);
		put("motors-switch", motors ? "Switch motors off" : "Switch motors on");
		put("hint", !mine ? "look only" : robot.locked ? "locked: unlock above" : !motors ? "motors are off" :
			helm.programs === "driving" ? "a program drives" : "hold arrows or stick");
	}

	updateList(model, chosen) {
		const many = model.list.length > 1 || model.hello.teacher === true;
		show("list", many);
		document.body.classList.toggle("many", many);
		items(byId("tiles"), model.list.map(robot => robot.number), (item, number) => {
			const button = document.createElement("button"), parts = ["number", "sign", "state", "volts", "who"].map(name =>
				Object.assign(document.createElement("span"), {className: name}));
			button.append(...parts);
			button.onclick = () => this.choose(number);
			item.append(button);
			this.tiles.set(number, [button, ...parts]);
		});
		for (const robot of model.list) {
			const [button, number, sign, state, volts, who] = this.tiles.get(robot.number), is = stateOf(robot), {battery} = robot.status;
			button.dataset.kind = is[0];
			put(number, String(robot.number));
			put(sign, is[1]);
			put(state, is[2]);
			put(volts, battery ? (battery.level === "ok" ? "" : "low ") + battery.volts.toFixed(1) + " V" : "");
			put(who, ["bad", "none"].includes(is[0]) ? robot.helm.who || robot.helm.commander || "" : "");
			const pressed = String(robot === chosen);
			if (button.ariaPressed === pressed) continue;
			button.ariaPressed = pressed;
			if (robot === chosen) button.scrollIntoView({block: "nearest", inline: "nearest"});
		}
	}
}
