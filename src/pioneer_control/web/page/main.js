// Wires all together: what comes in goes into the model, each picture is drawn from it, and only then the hand is told on.

import {Controls} from "./controls.js";
import {Deadman, Hand} from "./hand.js";
import {MapPicture} from "./map.js";
import {Model} from "./model.js";
import {Panel, byId, put, show} from "./panel.js";
import {Recording} from "./recording.js";
import {Live} from "./source.js";
import {TimeLine} from "./timeline.js";
import {Camera} from "./view.js";

const OLD = 500;		// ms: a picture older than this is called old
const SAID = 6000;		// ms that a message stays on the map
const LIMITS = [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8, 1, 1.2, 1.5, 2];		// m/s

const model = new Model(), camera = new Camera(), picture = new MapPicture(byId("floor"), byId("moving"), camera);
const hand = new Hand(), deadman = new Deadman(message => live.send(message)), stopsToSend = new Set(), ages = [];
const controls = new Controls(hand, {stop: () => timeline ? timeline.toggle() : stop(), gone: () => deadman.letGo(), key: pressed});
const panel = new Panel(choose, command => act({do: "gripper", command}));
let live = null, recording = null, timeline = null, chosen = null;
let redraw = true, rewrite = true, fitted = true, panelAt = 0, turnedAt = 0, saidAt = 0;

function changed() {
	redraw = rewrite = true;
}

function say(text) {
	put("said", text);
	show("said", true);
	saidAt = performance.now();
}

function act(message) {
	if (!live.send({robot: chosen && chosen.number, ...message})) say("No connection: nothing was sent.");
}

// A stop that cannot go now goes as soon as it can: it never does harm.
function stop(robot = chosen ? chosen.number : "all") {
	controls.drop();
	if (live.send({do: "stop", robot})) return;
	stopsToSend.add(robot);
	say("No connection: STOP goes out as soon as there is one.");
}

function choose(number) {
	controls.drop();
	chosen = model.robot(number) || model.list[0] || null;
	ages.length = 0;
	changed();
	if (timeline && chosen) timeline.show(chosen.number);
}

// The robots changed: keep the chosen one, if it is still there.
function keep() {
	if (chosen && model.list.includes(chosen)) return;
	choose((model.list.find(robot => robot.info.yours) || {}).number);
}

function step(way) {
	const at = model.list.indexOf(chosen) + way, {length} = model.list;
	if (length > 1) choose(model.list[(at + length) % length].number);
}

// --- What comes in ---

function text(kind, value) {
	if (kind === "recording") return record(value);
	model.take(kind, value);
	if (kind === "hello") greet();
	if (kind === "robots") keep();
	if (kind === "said") say(value.text);
	if (kind === "world" && fitted) fit();
	changed();
}

function greet() {
	const {title = "Robots", you = "", teacher} = model.hello;
	document.title = title;
	put("title", title);
	show("teacher", teacher);
	document.body.classList.toggle("teaches", teacher === true);
	if (document.activeElement !== byId("my-name")) byId("my-name").value = you.replace(/ /g, "_");
}

function frames(list) {
	for (const [frame, sent] of list) if (model.robot(frame.robot)) model.robot(frame.robot).take(frame, sent);
	changed();
	if (fitted && !model.world) fit();
}

function connection(state, reason) {
	const notice = {key: "Open this page with its whole address, as the server printed it: with # and the key at its end.",
		refused: reason, closed: reason}[state] || "";
	put("mode", {open: "live", connecting: "connecting", closed: "no connection", key: "no key", refused: "refused"}[state], state);
	show("notice", notice);
	put("notice", notice);
	if (state !== "open") return controls.drop();
	for (const robot of stopsToSend) live.send({do: "stop", robot});
	stopsToSend.clear();
}

async function record(value) {
	recording = new Recording(value, model);
	document.body.classList.add("recorded");
	show("time", true);
	put("mode", "recording");
	model.take("hello", {title: value.name});
	greet();
	timeline = new TimeLine(recording, () => {
		keep();
		changed();
	});
	timeline.seek(0);
	await recording.unpackAll();
	unpacked();
}

function unpacked() {
	timeline.seek(recording.at);
	if (chosen) timeline.show(chosen.number);
	fit();
}

// --- The view ---

function fit() {
	follow(false);
	const {offsetWidth: wide, offsetHeight: high} = byId("tools");
	camera.fit(model.bounds(), high > wide ? wide : 0, high > wide ? 0 : high);
	fitted = true;
}

function follow(on) {
	camera.follows = on;
	byId("follow").ariaPressed = String(on);
	changed();
}

function zoom(factor, pixel) {
	camera.zoom(factor, pixel);
	fitted = false;
	changed();
}

function pressed(key) {
	const action = {n: () => step(1), p: () => step(-1), f: () => follow(!camera.follows), 0: fit, "+": () => zoom(1.25), "=": () => zoom(1.25),
		"-": () => zoom(0.8), "?": openHelp, j: () => timeline && timeline.jump(-1), l: () => timeline && timeline.jump(1)}[key.toLowerCase()];
	if (action) action();
}

function listenMap() {
	const canvas = byId("moving"), fingers = new Map(), at = event => [event.offsetX, event.offsetY];
	const far = (one, other) => Math.hypot(one[0] - other[0], one[1] - other[1]);
	let moved = 0;
	canvas.onpointerdown = event => {
		canvas.setPointerCapture(event.pointerId);
		if (!fingers.size) moved = 0;
		fingers.set(event.pointerId, at(event));
	};
	canvas.onpointermove = event => {
		const before = fingers.get(event.pointerId), now = at(event), count = fingers.size;
		if (!before) return;
		moved += far(now, before);
		const other = [...fingers].filter(([id]) => id !== event.pointerId).map(([, place]) => place)[0];
		fingers.set(event.pointerId, now);
		if (other) zoom(far(now, other) / Math.max(1, far(before, other)), [(now[0] + other[0]) / 2, (now[1] + other[1]) / 2]);
		else if (moved > 6) follow(false);
		if (camera.follows || moved <= 6) return;
		camera.drag((now[0] - before[0]) / count, (now[1] - before[1]) / count);
		fitted = false;
		changed();
	};
	canvas.onpointerup = canvas.onpointercancel = event => {
		const robot = event.type === "pointerup" && moved <= 6 && picture.robotAt(model, at(event));
		if (robot) choose(robot.number);
		fingers.delete(event.pointerId);
	};
	canvas.addEventListener("wheel", event => {
		event.preventDefault();
		zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), at(event));
	}, {passive: false});
	new ResizeObserver(dress).observe(canvas);
}

function dress() {
	picture.dress();
	if (fitted) fit();
	if (timeline && chosen) timeline.show(chosen.number);
	changed();
}

// --- Buttons ---

function openHelp() {
	controls.drop();
	byId("help").showModal();
}

function setTheme(theme) {
	document.documentElement.dataset.theme = theme;
	dress();
}

function raise(way) {
	const limit = (chosen.helm.limit || [0.2])[0], most = chosen.info.max_linear || 2;
	const steps = LIMITS.filter(each => way * (each - limit) > 0.001), linear = way > 0 ? Math.min(most, ...steps) : Math.max(...steps);
	if (steps.length && way * (linear - limit) > 0) act({do: "limit", linear});
}

// The space bar is STOP even in a text: there, _ is written for a space.
function listenForm(form, field, make) {
	byId(form).onsubmit = event => {
		event.preventDefault();
		const words = byId(field).value.replace(/_/g, " ").trim();
		if (words && live.send(make(words)) && form === "say") byId(field).value = "";
		byId(field).blur();
	};
}

// A finger on STOP counts when it comes down; the click that follows is the same one.
function listenStop(id, robot) {
	let down = -Infinity;
	byId(id).onpointerdown = event => {
		if (event.button) return;
		down = event.timeStamp;
		stop(robot);
	};
	byId(id).onclick = event => event.timeStamp - down > 1000 && stop(robot);
}

function listenButtons() {
	listenStop("stop");
	listenStop("stop-all", "all");
	const actions = {
		unlock: () => act({do: "unlock"}), "unlock-all": () => act({do: "unlock", robot: "all"}), take: () => act({do: "take"}),
		release: () => act({do: "release"}), "motors-switch": () => act({do: "motors", on: byId("motors").textContent === "off"}),
		slower: () => raise(-1), faster: () => raise(1), previous: () => step(-1), next: () => step(1), "zoom-in": () => zoom(1.25),
		"zoom-out": () => zoom(0.8), fit, follow: () => follow(!camera.follows), "help-open": openHelp,
		theme: () => setTheme(kept(localStorage, "theme", document.documentElement.dataset.theme === "dark" ? "light" : "dark")),
	};
	for (const [id, action] of Object.entries(actions)) byId(id).onclick = action;
	listenForm("say", "say-text", words => ({do: "say", text: words}));
	listenForm("me", "my-name", words => ({do: "name", name: words}));
}

// --- Each picture ---

function ageText(ms) {
	return ms < 1000 ? `${Math.round(ms)} ms` : `${(ms / 1000).toFixed(1)} s`;
}

function showAge(now) {
	const none = !chosen || !chosen.frame;
	const age = none ? Infinity : recording ? 1000 * recording.age(chosen) : 1000 * chosen.frame.age + now - chosen.sent, old = age > OLD;
	ages.push([now, age]);
	while (ages[0][0] < now - OLD) ages.shift();		// the worst of half a second: a number that can be read
	put("age-text", none ? "none" : ageText(old ? age : Math.max(...ages.map(each => each[1]))) + " old");
	document.body.classList.toggle("is-old", old && chosen !== null);
	show("old", old && chosen);
	put("old-words", !old ? "" : recording ? "NO DATA" : none ? "NO PICTURE" : "OLD PICTURE:");
	put("old-age", old && !none ? ageText(age) : "");
}

function turn() {
	requestAnimationFrame(turn);
	const now = performance.now();
	controls.poll();
	if (timeline) timeline.advance((now - turnedAt) / 1000);
	turnedAt = now;
	const want = hand.wants(), frame = chosen && chosen.frame;
	if (camera.follows && frame) camera.set(model.pose(chosen));
	if (redraw || want) {
		picture.draw(model, chosen);
		if (timeline) timeline.draw();
		redraw = false;
	}
	if (live) {		// right after the drawing: what was drawn, and where the hand wants to go by this picture
		live.drawn(now);
		if (want && !(frame && live.open && chosen.info.yours !== false && !chosen.locked && !byId("help").open)) controls.drop();
		else if (frame) deadman.drawn(want, chosen.number, frame.stamp, chosen.sent, now);
	}
	if (rewrite && now - panelAt > 80) {
		panel.update(model, chosen, live !== null);
		[panelAt, rewrite] = [now, false];
	}
	showAge(now);
	if (now - saidAt > SAID) show("said", false);
}

// --- Beginning ---

// What the browser keeps under a name. It may forbid that: then nothing is kept.
function kept(storage, name, value) {
	try {
		if (value) storage.setItem(name, value);
		return storage.getItem(name);
	} catch (error) {
		return value;
	}
}

function firstWords() {
	const key = kept(sessionStorage, "key", location.hash.slice(1)) || "";
	history.replaceState(null, "", location.pathname);
	const made = Array.from(crypto.getRandomValues(new Uint8Array(32)), each => (each % 36).toString(36)).join("");
	return {key, visitor: kept(localStorage, "visitor") || kept(localStorage, "visitor", made)};
}

function begin() {
	const dark = matchMedia("(prefers-color-scheme: dark)"), inside = byId("recording");
	dark.onchange = () => setTheme(kept(localStorage, "theme") || (dark.matches ? "dark" : "light"));
	dark.onchange();
	listenMap();
	listenButtons();
	if (inside) record(JSON.parse(inside.textContent));
	else {
		live = new Live(location.origin.replace("http", "ws") + "/page", firstWords(), {text, frames, state: connection,
			columns: buffer => recording.unpack(new DataView(buffer).getUint16(1, true), new Uint8Array(buffer, 3)).then(unpacked)});
		window.onhashchange = () => location.hash.length > 1 && location.reload();
	}
	turn();
}

begin();
