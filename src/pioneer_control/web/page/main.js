// Wires all together: what comes in goes into the model, each picture is drawn from it, and only then the hand is told on.

import {Controls} from "./controls.js";
import {Deadman, Hand} from "./hand.js";
import {MapPicture} from "./map.js";
import {Model} from "./model.js";
import {$, Panel, put, show} from "./panel.js";
import {Recording, unpacked} from "./recording.js";
import {Live} from "./source.js";
import {TimeLine} from "./timeline.js";
import {Camera, listenView} from "./view.js";

const OLD = 500;	// ms: a picture older than this is called old
const READ = 400;	// ms that a number stays, to be read
const SAID = 6000;	// ms that a message stays on the map
const NO_KEY = "Open this page with its whole address, as the server printed it: with # and the key at its end.";

const model = new Model(), camera = new Camera(), picture = new MapPicture($("floor"), $("moving"), camera), root = document.documentElement;
const hand = new Hand(), deadman = new Deadman(message => live.send(message)), stopsToSend = new Set();
const controls = new Controls(hand, {stop: () => timeline ? timeline.toggle() : stop(), gone: () => deadman.letGo(), key: pressed});
const panel = new Panel(choose, command => act({do: "gripper", command}));
let live = null, recording = null, timeline = null, chosen = null, unpacking = Promise.resolve();
let redraw = true, rewrite = true, fitted = true, panelAt = 0, turnedAt = 0, saidAt = 0, ageAt = 0, worst = 0;

function changed() {
	redraw = rewrite = true;
}

function say(text) {
	put("said", text);
	saidAt = performance.now();
}

function act(message) {
	if (!live.send({robot: chosen?.number, ...message})) say("No connection: nothing was sent.");
}

// A stop that cannot go now goes as soon as it can: it never does harm.
function stop(robot = chosen?.number ?? "all") {
	controls.drop();
	if (live.send({do: "stop", robot})) return;
	stopsToSend.add(robot);
	say("No connection: STOP goes out as soon as there is one.");
}

function choose(number) {
	controls.drop();
	chosen = model.robot(number) || model.list[0] || null;
	worst = 0;
	timeline?.dress(chosen?.number);
	changed();
}

// The robots may have changed: keep the chosen one, if it is still there.
function keep() {
	if (!model.list.includes(chosen)) choose(model.list.find(robot => robot.info.yours)?.number);
	changed();
}

function step(way) {
	const {list} = model;
	if (list.length > 1) choose(list[(list.indexOf(chosen) + way + list.length) % list.length].number);
}

// --- What comes in ---

function text(kind, value) {
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
	if (document.activeElement !== $("my-name")) $("my-name").value = you.replace(/ /g, "_");
}

function frames(list) {
	for (const [frame, sent] of list) model.robot(frame.robot)?.take(frame, sent);
	if (fitted && !model.world) fit();
	changed();
}

function connection(state, reason) {
	put("mode", state);
	put("notice", state === "no key" ? NO_KEY : reason);
	if (state !== "live") return controls.drop();
	for (const robot of stopsToSend) live.send({do: "stop", robot});
	stopsToSend.clear();
}

// Bytes of a recording: first what was said (3), then the columns of each robot (2). One after the other, as they came.
function recorded(data) {
	const columns = new Uint8Array(data)[0] === 2;
	unpacking = unpacking.then(async () => {
		if (columns) await recording.unpack(new DataView(data).getUint16(1, true), new Uint8Array(data, 3));
		else record(JSON.parse(await new Response(await unpacked(new Uint8Array(data, 1))).text()));
		dress();
	});
}

async function record(value) {
	recording = new Recording(value, model);
	document.body.classList.add("recorded");
	show("time", true);
	put("mode", "recording");
	greet({title: value.name});
	timeline = new TimeLine(recording, keep);
	timeline.seek(0);
	for (const {robot, data} of value.columns) if (data) await recording.unpack(robot, Uint8Array.from(atob(data), each => each.charCodeAt()));
	dress();
}

// --- The view ---

function fit() {
	follow(false);
	camera.fit(model.bounds());
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
	timeline?.seek(recording.at);
	timeline?.dress(chosen?.number);
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
	theme: () => setTheme(kept(localStorage, "theme", root.dataset.theme === "dark" ? "light" : "dark")),
	"mark-previous": () => timeline.jump(-1), "mark-next": () => timeline.jump(1), play: () => timeline.toggle(),
};

// A key does what the button does that names it, if it can be seen.
function pressed(key) {
	const button = document.querySelector(`[aria-keyshortcuts~="${CSS.escape(key.toUpperCase())}"]`);
	if (button?.checkVisibility()) button.click();
}

// In steps: 0.05 m/s, from 0.3 on 0.1.
function raise(way) {
	const limit = chosen.helm.limit[0], size = limit + way * 0.01 < 0.3 ? 20 : 10, linear = (Math.round(limit * size) + way) / size;
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
	}, at => choose((picture.robotAt(model, at) || chosen)?.number));
	new ResizeObserver(dress).observe($("moving"));
}

// --- Each picture ---

function ageText(ms) {
	return ms === Infinity ? "none" : ms < 1000 ? `${Math.round(ms)} ms old` : `${(ms / 1000).toFixed(1)} s old`;
}

// How old what the chosen robot shows is (ms).
function ageOf({frame, sent}, now) {
	return !frame ? Infinity : recording ? 1000 * recording.at - frame.stamp : 1000 * frame.age + now - sent;
}

function showAge(now) {
	const age = chosen ? ageOf(chosen, now) : Infinity, old = chosen !== null && age > OLD;
	worst = Math.max(worst, age);
	document.body.classList.toggle("is-old", old);
	show("old", old);
	put("old-words", !old ? "" : recording ? "NO DATA" : chosen.frame ? "OLD PICTURE:" : "NO PICTURE");
	put("old-age", old && chosen.frame ? ageText(age) : "");
	if (now - ageAt < READ && !old) return;
	put("age-text", ageText(worst));
	[ageAt, worst] = [now, 0];
}

function turn() {
	requestAnimationFrame(turn);
	const now = performance.now();
	controls.poll();
	timeline?.advance((now - turnedAt) / 1000);
	turnedAt = now;
	const want = hand.wants(), frame = chosen?.frame;
	if (camera.follows && frame) camera.set({x: model.pose(chosen).x, y: model.pose(chosen).y});
	if (redraw || want) {
		picture.draw(model, chosen);
		timeline?.draw();
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
	if (now - saidAt > SAID) put("said");
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
	else live = new Live(location.origin.replace("http", "ws") + "/page", firstWords(), {text, frames, state: connection, recorded});
	window.onhashchange = () => live && location.hash.length > 1 && location.reload();
	turn();
}

begin();
