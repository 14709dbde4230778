// The words beside the map: the chosen robot, the list of all, what the server said. As texts, never as markup.

import {FLAG, GRIP} from "./frames.js";
import {stateOf} from "./model.js";

export function $(id) {
	return document.getElementById(id);
}

// Only what changed: a screen reader says it. The style sheet hides what has no words.
export function put(element, text, colour) {
	if (typeof element === "string") element = $(element);
	if (element.textContent !== (text || "")) element.textContent = text || "";
	tint(element, colour);
}

function tint(element, colour) {
	element.style.color = colour ? `var(--${colour})` : "";
}

export function show(id, shown) {
	$(id).hidden = !shown;
}

export function make(parent, tag, more) {
	const element = Object.assign(document.createElement(tag), more);
	parent.append(element);
	return element;
}

export function clockText(at) {
	return `${at / 60 | 0}:${(at % 60).toFixed(1).padStart(4, "0")}`;
}

export function items(list, values, fill) {
	const key = JSON.stringify(values);
	if (list.dataset.key === key) return;
	list.dataset.key = key;
	list.replaceChildren();
	for (const value of values) fill(make(list, "li"), value);
}

// What is so, and its level: the name of a colour where it is bad.
const NUMBERS = {
	Forward: ({frame}) => [frame.linear.toFixed(2) + " m/s"],
	Turn: ({frame}) => [turnText(Math.round(frame.angular * 180 / Math.PI))],
	Battery: robot => batteryText(robot.status.battery || {}, robot.is(FLAG.charging)),
	Motors: robot => [robot.is(FLAG.motors) ? "on" : "off"],
	Wheels: robot => flagged(robot, "not stalled", {"left stalled": FLAG.stallLeft, "right stalled": FLAG.stallRight}),
	"Bumpers, button": robot => flagged(robot, "not pressed", {"front bumper": FLAG.bumpFront, "rear bumper": FLAG.bumpRear, "STOP button": FLAG.button}),
	Gripper: ({frame: {gripper}}) => [gripper ? named(gripper, GRIP) || "half open" : "none"],
};

function named(bits, words) {
	return Object.keys(words).filter(word => bits & words[word]).join(", ");
}

function flagged({frame}, good, words) {
	const found = named(frame.flags, words);
	return [found || good, found && "error"];
}

function turnText(degrees) {
	return Math.abs(degrees) + " °/s" + (degrees > 0 ? " left" : degrees ? " right" : "");
}

function batteryText({volts, charge, level}, charging) {
	const words = [volts?.toFixed(1) + " V", charge !== null && Math.round(100 * charge) + " %", {warn: "low", error: "empty"}[level], charging && "charging"];
	return volts ? [words.filter(Boolean).join(" · "), level] : ["not known"];
}

// Who drives, and a hint. other: not this hand
function driver({locked, helm: {commander, who, locks}}, motors, other, denied) {
	return locked ? [denied ? "Stopped by the teacher" : "Stopped until somebody unlocks", locks.filter(lock => lock !== "stop").join(", ")] :
		[other ? `${who || "Somebody"} drives` : {program: "A program drives", person: "You drive"}[commander] || "Nobody drives",
			!motors ? "Switch motors on to drive." : other && "If you drive, you take over."];
}

for (const title in NUMBERS) {
	const cell = make($("numbers"), "div");
	make(cell, "dt", {textContent: title});
	make(cell, "dd", {id: title});
}

export function showAll({list, log, students}, robot, live) {
	showList(list, robot, students);
	items($("log"), log, (item, {robot, text, level}) => put(item, (robot ? robot + ": " : "") + text, level));
	show("panel", robot || document.body.matches(".joins"));
	if (robot) showRobot(robot, live, live && robot.info.yours !== false);
}

// The task of a class, for who has this robot. The same points are the same place; none are no place yet.
export function showTask(task, own) {
	show("task", task);
	$("tasks").value = task?.name || "";
	if (!task) return;
	const {title, text, state, clock, limit, ranking} = task;
	put("task-title", "Task: " + title);
	put("task-text", text);
	put("task-clock", `${state}: ${clockText(clock)} of ${clockText(limit)}`);
	const lines = ranking.filter(({who, points}) => who || points).map(({robot, who, points, note}) => [
		`${points ? 1 + ranking.findIndex(each => each.points === points) + "." : "–"} ${who || "robot"} (${robot}): ${points} points${note && ", " + note}`, robot === own && "person"]);
	items($("ranking"), lines, (item, line) => put(item, ...line));
}

function showRobot(robot, live, mine) {
	const {number, info, frame, helm: {commander, you, teacher, locks, programs, limit}, program: {path, key}, status} = robot, {decision, faults, link, lost} = status, locked = locks.length > 0;
	const [kind, sign] = stateOf(robot), motors = robot.is(FLAG.motors), other = commander === "person" && !you, student = $("teacher").hidden;
	const denied = student && teacher, theirs = !mine || other && student, [words, note] = driver(robot, motors, other, denied);
	const texts = {number: "" + number, name: robot.own ? "Your robot" : info.name, model: info.model + (info.simulated ? " · simulated" : ""),
		"driver-text": `${sign} ${words}`, "driver-note": !live ? "" : theirs ? "Not yours: look only." : note,
		doing: decision?.doing, why: decision?.why && "because " + decision.why, "limit-text": limit[0].toFixed(2) + " m/s",
		unlock: mine && locked && !denied && "Unlock", take: mine && !locked && !you && /driv|free/.test(programs) && "Drive by hand",
		release: mine && !locked && programs === "locked out" && "Let programs drive",
		program: mine && $("class").hidden && key && `In your program: Robot("ws://${location.host}${path}", key="${key}")`,
		"motors-switch": mine && "Switch motors " + (motors ? "off" : "on")};
	for (const id in texts) put(id, texts[id]);
	show("decision", decision?.doing);
	for (const title in NUMBERS) put(title, ...frame ? NUMBERS[title](robot) : ["–"]);
	tint($("helm"), kind);
	items($("faults"), link === "ok" ? faults : [{level: "error", task: "No link", text: lost || link}, ...faults],
		(item, {level, task, text}) => put(item, `${level === "error" ? "✖" : "▲"} ${task}: ${text}`, level));
	document.body.classList.toggle("theirs", theirs || robot.locked);
	show("grip", frame?.gripper);
}

function showList(list, chosen, students) {
	const tiles = $("tiles");
	show("list", list.length > 1 || !$("task").hidden);
	$("unlock-all").disabled = !list.some(robot => robot.locked);
	items(tiles, list.map(robot => robot.number), (item, value) => make(item, "button", {value}));
	list.forEach((robot, i) => {
		const button = tiles.children[i].firstChild, [kind, sign, word] = stateOf(robot), pressed = "" + (robot === chosen);
		const {status: {battery}, helm: {who}} = robot, volts = battery && batteryText(battery)[0];
		put(button, `${robot.number} ${sign} ${word}\n${[students?.get(robot.number) || who, volts].filter(Boolean).join(" · ")}`, kind);
		if (button.getAttribute("aria-pressed") === pressed) return;
		button.setAttribute("aria-pressed", pressed);
		if (robot === chosen) button.scrollIntoView({block: "nearest", inline: "nearest"});
	});
}
