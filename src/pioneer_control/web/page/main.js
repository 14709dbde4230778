// Wires all together: what comes in goes into the model, each picture is drawn from it, and only then the hand is told on.

import {Controls} from "./controls.js";
import {Deadman, Hand} from "./hand.js";
import {MapPicture} from "./map.js";
import {Model} from "./model.js";
import {$, Panel, put, show} from "./panel.js";
import {Recording} from "./recording.js";
import {Live} from "./source.js";
import {TimeLine} from "./timeline.js";
import {Camera, listenView} from "./view.js";

const OLD = 500;	// ms: a picture older than this is called old
const SAID = 6000;	// ms that a message stays on the map
const STATES = {open: "live", connecting: "connecting", closed: "no connection", key: "no key", refused: "refused"};
const NO_KEY = "Open this page with its whole address, as the server printed it: with # and the key at its end.";

const model = new Model(), camera = new Camera(), picture = new MapPicture($("floor"), $("moving"), camera), root = document.documentElement;
const hand = new Hand(), deadman = new Deadman(message => live.send(message)), stopsToSend = new Set();
const controls = new Controls(hand, {stop: () => timeline ? timeline.toggle() : stop(), gone: () => deadman.letGo(), key: pressed});
const panel = new Panel(choose, command => act({do: "gripper", command}));
let live = null, recording = null, timeline = null, chosen = null, ages = [];
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
	ages = [];
	changed();
	if (timeline && chosen) timeline.show(chosen.number);
}

// The robots may have changed: keep the chosen one, if it is still there.
function keep() {
	if (!model.list.includes(chosen)) choose((model.list.find(robot => robot.info.yours) || {}).number);
	changed();
}

function step(way) {
	const {list} = model;
	if (list.length > 1) choose(list[(list.indexOf(chosen) + way + list.length) % list.length].number);
}

// --- What comes in ---

function text(kind, value) {
	if (kind === "recording") return record(value);
	model.take(kind, value);
	if (kind === "hello") greet(value);
	if (kind === "said") say(value.text);
	if (kind === "world" && fitted) fit();
	keep();
}

function greet({title, you = "", teacher = false}) {
	document.title = title;
	put("title", title);
	show("teacher", teacher);
	document.body.classList.toggle("teaches", teacher);
	if (document.activeElement !== $("my-name")) $("my-name").value = you.replace(/ /g, "_");
}

function frames(list) {
	for (const [frame, sent] of list) if (model.robot(frame.robot)) model.robot(frame.robot).take(frame, sent);
	if (fitted && !model.world) fit();
	changed();
}

function connection(state, reason) {
	const notice = state === "key" ? NO_KEY : reason || "";
	put("mode", STATES[state]);
	show("notice", notice);
	put("notice", notice);
	if (state !== "open") return controls.drop();
	for (const robot of stopsToSend) live.send({do: "stop", robot});
	stopsToSend.clear();
}

function record(value) {
	recording = new Recording(value, model);
	document.body.classList.add("recorded");
	show("time", true);
	put("mode", "recording");
	greet({title: value.name});
	timeline = new TimeLine(recording, keep);
	timeline.seek(0);
	recording.unpackAll().then(unpacked);
}

function unpacked() {
	timeline.seek(recording.at);
	dress();
}

// --- The view ---

function fit() {
	const {offsetWidth: wide, offsetHeight: high} = $("tools"), beside = wide / camera.width < high / camera.height;
	follow(false);
	camera.fit(model.bounds(), beside ? wide : 0, beside ? 0 : high);
	fitted = true;
}

function follow(on) {
	camera.follows = on;
	$("follow").ariaPressed = String(on);
	changed();
}

function dress() {
	picture.dress();
	if (fitted) fit();
	if (timeline && chosen) timeline.show(chosen.number);
	changed();
}

function setTheme(theme) {
	root.dataset.theme = theme;
	dress();
}

// --- Keys and buttons ---

const ACTIONS = {
	unlock: () => act({do: "unlock"}), "unlock-all": () => act({do: "unlock", robot: "all"}), take: () => act({do: "take"}),
	release: () => act({do: "release"}), "motors-switch": () => act({do: "motors", on: $("motors").textContent === "off"}),
	slower: () => raise(-1), faster: () => raise(1), previous: () => step(-1), next: () => step(1), fit, follow: () => follow(!camera.follows),
	"zoom-in": () => camera.zoom(1.25), "zoom-out": () => camera.zoom(0.8),
	"help-open": () => {
		controls.drop();
		$("help").showModal();
	},
	"help-close": () => $("help").close(),
	theme: () => setTheme(kept(localStorage, "theme", root.dataset.theme === "dark" ? "light" : "dark")),
	"mark-previous": () => timeline && timeline.jump(-1), "mark-next": () => timeline && timeline.jump(1), play: () => timeline.toggle(),
};
const KEY_ACTIONS = {n: "next", p: "previous", f: "follow", 0: "fit", "+": "zoom-in", "=": "zoom-in", "-": "zoom-out", "?": "help-open",
	j: "mark-previous", l: "mark-next"};

function pressed(key) {
	const action = ACTIONS[KEY_ACTIONS[key.toLowerCase()]];
	if (action) action();
}

// In steps: 0.05 m/s, from 0.3 on 0.1.
function raise(way) {
	const limit = (chosen.helm.limit || [0.2])[0], size = limit + way * 0.01 < 0.3 ? 20 : 10, linear = (Math.round(limit * size) + way) / size;
	act({do: "limit", linear: Math.max(0.05, Math.min(chosen.info.max_linear || 2, linear))});
}

// The space bar is STOP even in a text: there, _ is written for a space.
function listenForm(field, make) {
	$(field).form.onsubmit = event => {
		event.preventDefault();
		const words = $(field).value.replace(/_/g, " ").trim();
		if (words) live.send(make(words));
		if (field === "say-text") $(field).value = "";
		$(field).blur();
	};
}

// A finger on STOP counts when it comes down; the click that follows is the same one.
function listenStop(id, robot) {
	let down = -Infinity;
	$(id).onpointerdown = event => {
		down = event.timeStamp;
		stop(robot);
	};
	$(id).onclick = event => event.timeStamp - down > 1000 && stop(robot);
}

function listen() {
	for (const [id, action] of Object.entries(ACTIONS)) $(id).onclick = action;
	listenStop("stop");
	listenStop("stop-all", "all");
	listenForm("say-text", text => ({do: "say", text}));
	listenForm("my-name", name => ({do: "name", name}));
	listenView($("moving"), camera, moved => {
		fitted = false;
		if (camera.follows && moved === "dragged") follow(false);
		changed();
	}, at => choose((picture.robotAt(model, at) || chosen || {}).number));
	new ResizeObserver(dress).observe($("moving"));
}

// --- Each picture ---

function ageText(ms) {
	return ms < 1000 ? `${Math.round(ms)} ms` : `${(ms / 1000).toFixed(1)} s`;
}

function showAge(now) {
	const frame = chosen && chosen.frame, old = () => ages[ages.length - 1][1] > OLD;
	ages.push([now, !frame ? Infinity : recording ? 1000 * recording.age(chosen) : 1000 * frame.age + now - chosen.sent]);
	ages = ages.filter(each => each[0] >= now - OLD);		// the worst of half a second: a number that can be read
	const age = old() ? ages[ages.length - 1][1] : Math.max(...ages.map(each => each[1]));
	put("age-text", frame && age < Infinity ? ageText(age) + " old" : "none");
	document.body.classList.toggle("is-old", old() && chosen !== null);
	show("old", old() && chosen);
	put("old-words", !old() ? "" : recording ? "NO DATA" : frame ? "OLD PICTURE:" : "NO PICTURE");
	put("old-age", old() && frame ? ageText(age) : "");
}

function turn() {
	requestAnimationFrame(turn);
	const now = performance.now();
	controls.poll();
	if (timeline) timeline.advance((now - turnedAt) / 1000);
	turnedAt = now;
	const want = hand.wants(), frame = chosen && chosen.frame;
	if (camera.follows && frame) camera.set({x: model.pose(chosen).x, y: model.pose(chosen).y});
	if (redraw || want) {
		picture.draw(model, chosen);
		if (timeline) timeline.draw();
		redraw = false;
	}
	if (!recording && live) {		// right after the drawing: what was drawn, and where the hand wants to go by this picture
		live.drawn(now);
		if (want && !(frame && live.open && chosen.info.yours !== false && !chosen.locked && !$("help").open)) controls.drop();
		else if (frame) deadman.drawn(want, chosen.number, frame.stamp, chosen.sent, now);
	}
	if (rewrite && now - panelAt > 80) {
		panel.update(model, chosen, !recording);
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
	const dark = matchMedia("(prefers-color-scheme: dark)"), inside = $("recording");
	dark.onchange = () => setTheme(kept(localStorage, "theme") || (dark.matches ? "dark" : "light"));
	dark.onchange();
	listen();
	if (inside) record(JSON.parse(inside.textContent));
	else live = new Live(location.origin.replace("http", "ws") + "/page", firstWords(), {text, frames, state: connection,
		columns: data => recording.unpack(new DataView(data).getUint16(1, true), new Uint8Array(data, 3)).then(unpacked)});
	window.onhashchange = () => live && location.hash.length > 1 && location.reload();
	turn();
}

begin();
