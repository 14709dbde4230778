// What comes in fills the model, each picture is drawn from it, then the hand is told on.

import {listenHand} from "./controls.js";
import {Deadman, Hand} from "./hand.js";
import {MapPicture} from "./map.js";
import {Model} from "./model.js";
import {$, items, put, show, showAll, showTask} from "./panel.js";
import {Recording, unpacked} from "./recording.js";
import {Live} from "./source.js";
import {TimeLine} from "./timeline.js";
import {Camera, listenView} from "./view.js";

const OLD = 500, READ = 400, SAID = 6000, TICK = 200;		// ms: a picture is old; a number, a message stay; a turn at least

const model = new Model(), camera = new Camera(), picture = new MapPicture($("floor"), $("moving"), camera);
const hand = new Hand(), deadman = new Deadman(message => live.send(message)), stopsToSend = new Set();
const controls = listenHand(hand, {stop: () => timeline ? timeline.toggle() : stop(), gone: () => deadman.letGo(), key: pressed});
const mine = {};		// in a class: this student's robot
const toStop = () => mine.robot ?? chosen?.number ?? "all";
let live = null, recording = null, timeline = null, chosen = null, unpacking = null, dirty = true, drawn = true, turnedAt = 0, asked = 0, saidAt = 0, ageAt = 0, loading, navigation;

// Sooner than the next turn of an endless row.
const wake = () => asked ||= requestAnimationFrame(turn);

function redraw() {
	dirty = true;
	wake();
}

function say(text) {
	put("said", text);
	saidAt = performance.now();
}

function act(order, more, robot) {
	if (!live.send({do: order, ...more, robot: robot === "none" ? undefined : robot || chosen?.number})) say("No connection: nothing was sent.");
}

// A stop that cannot go now goes as soon as it can: it never does harm.
function stop(robot = toStop()) {
	controls.drop();
	if (live.send({do: "stop", robot})) return;
	stopsToSend.add(robot);
	say("No connection: STOP goes out when there is one.");
}

function choose(number) {
	controls.drop();
	chosen = model.robot(number) || model.list[0];
	timeline?.dress(chosen?.number);
	redraw();
}

function changed() {
	if (!model.list.includes(chosen)) choose(model.list.find(robot => robot.info.yours)?.number);
	redraw();
}

const TEXTS = {
	hello: greet, join, class: showClass, faults: list => items($("faults-on"), list, put), said: ({text}) => say(text), mine: value => Object.assign(mine, value),
};

function text(kind, value) {
	model.take(kind, value);
	TEXTS[kind]?.(value);
	if ("name" in mine && $("teacher").hidden) for (const robot of model.list) robot.own = robot.info.yours = robot.number === mine.robot;
	if (kind === "mine" && mine.robot) {
		choose(mine.robot);
		Object.assign(camera, {scale: camera.height / 6, follows: true, fitted: false});
	}
	changed();
	showTask(model.task, mine.robot);
}

function greet({title, you = "", teacher}) {
	document.title = title;
	put("title", title);
	show("teacher", teacher);
	if (document.activeElement !== $("my-name")) $("my-name").value = you.replace(/ /g, "_");
}

function join(wanted) {
	mine.joins = wanted;
	document.body.classList.toggle("joins", wanted);
	put("my-label", wanted ? "Type your name to get a robot." : "Your name");
	put("my-send", wanted ? "Join" : "Set");
	if (!wanted) return;
	show("panel", true);
	$("my-name").focus();
}

function showClass({address, qr, students, paused, speed, tasks}) {
	show("class", true);
	show("code-open", true);
	$("tasks").replaceChildren(new Option("no task", ""), ...tasks.map(([name, title]) => new Option(title, name)));
	Object.assign($("class-code"), {src: qr, hidden: !qr});
	put("class-address", address);
	put("pause", paused ? "Go on" : "Pause");
	$("speed").value = speed;
	model.students = new Map(students.map(([robot, name, state]) => [robot, name + (state === "here" ? "" : ", away")]));
}

function frames(list) {
	for (const [frame, sent] of list) model.robot(frame.robot)?.take(frame, sent);
	redraw();
}

function state(name, reason) {
	put("mode", name);
	if (name !== "connecting") put("notice", reason || name !== "live" && "No connection: the run has ended, or the network is broken.");
	document.body.classList.toggle("dead", name !== "live");
	if (name !== "live") return controls.drop();
	for (const robot of stopsToSend) stop(robot);
	stopsToSend.clear();
}

async function recorded(data) {
	await unpacking;
	const bytes = new Uint8Array(data);
	if (bytes[0] === 3) unpacking = unpacked(bytes.subarray(1)).json().then(record);
	else unpack(bytes[1] + 256 * bytes[2], bytes.subarray(3));
}

function record(value) {
	recording = new Recording({...value, at: recording?.at}, model);		// said again after a break
	timeline = new TimeLine(recording, changed);
	show("dock");
	show("me");
	show("time", true);
	put("mode", "recording");
	greet({title: value.name});
	dress();
	for (const {robot, data} of value.columns) if (data) unpack(robot, Uint8Array.from(atob(data), each => each.charCodeAt()));
}

function unpack(robot, packed) {
	recording.unpack(robot, packed).then(dress);
}

function dress() {
	picture.dress();
	timeline?.seek(recording.at);
	timeline?.dress(chosen?.number);
	redraw();
}

const ACTIONS = {
	"motors-switch": () => act("motors", {on: $("Motors").textContent === "off"}), slower: () => raise(-0.05), faster: () => raise(0.05),
	fit: () => camera.fitted = true, "zoom-in": () => camera.zoom(1.25), "zoom-out": () => camera.zoom(0.8),
	follow: () => Object.assign(camera, {follows: !camera.follows, fitted: false}),
	"mark-previous": () => timeline.jump(-1), "mark-next": () => timeline.jump(1), play: () => timeline.toggle(),
	pause: () => act("pause", {on: $("pause").textContent === "Pause"}, "none"),
	"help-open": () => open("help"), "code-open": () => open("code"),
};

function open(dialog) {
	controls.drop();
	$(dialog).showModal();
}

function pressed(key) {
	const button = document.querySelector(`[aria-keyshortcuts~="${CSS.escape(key.toUpperCase())}"]`);
	if (button?.offsetParent) button.click();
}

function raise(by) {
	const linear = Math.max(0.05, Math.min(chosen.info.max_linear || 2, chosen.helm.limit[0] + by));
	act("limit", {linear: +linear.toFixed(2)});
}

// The space bar is STOP even in a text: there, _ is written for a space, but not in the fault stop_button.
function listenForm(field, send) {
	field.form.onsubmit = event => {
		event.preventDefault();
		const words = field.value.replace(/_(?!button)/g, " ").trim();
		if (words) send(words, event.submitter);
		field.blur();
	};
}

// A finger on STOP counts when it comes down. A click of the keyboard has no detail.
function listenStop(button, robot) {
	button.onpointerdown = () => stop(robot);
	button.onclick = event => event.detail || stop(robot);
}

document.onclick = ({target: {id, name, value}}) => {
	ACTIONS[id]?.();
	if (name) act(name, {}, value);
	redraw();
};
$("tiles").onclick = event => choose(+event.target.closest("button").value);
$("grip").onclick = event => act("gripper", {command: event.target.value});
listenStop($("stop"));
listenStop($("stop-all"), "all");
listenForm($("my-name"), name => live.send({do: mine.joins ? "join" : "name", name}));
listenForm($("fault"), (words, {value}) => act("fault", {words}, value));
$("tasks").onchange = event => act("task", {name: event.target.value}, "none");
$("speed").onchange = event => act("speed", {speed: +event.target.value}, "none");
listenForm($("say-text"), text => {
	if (live.send({do: "say", text})) $("say-text").value = "";
});
listenView($("moving"), camera, redraw, at => choose(picture.robotAt(at) ?? chosen?.number));

function turn() {
	asked = 0;
	if (controls.poll()) wake();
	const now = performance.now(), want = hand.wants(), frame = chosen?.frame;
	timeline?.advance((now - turnedAt) / 1000);
	turnedAt = now;
	try {		// the server waits until it is told
		if (dirty) drawAll(frame);
		[dirty, drawn] = [false, true];
	} catch (error) {
		drawn = false;
		console.error(error);
	}
	if (live && !recording) {		// right after the drawing: what was drawn, and where the hand wants to go by this picture
		live.drawn(now);
		if (want && !(frame && drawn && live.open && chosen.info.yours !== false && !chosen.locked && !document.querySelector("dialog[open]"))) controls.drop();
		else if (frame) deadman.drawn(want, chosen.number, frame.stamp, chosen.sent, now);
	}
	showAge(now, drawn && frame);
	if (now - saidAt > SAID) put("said");
}

function drawAll(frame) {
	if (camera.fitted && model.world) camera.fit(model.world.bounds, $("legend").offsetHeight + 9);
	if (frame && (camera.follows || camera.fitted && !model.world)) [camera.x, camera.y] = model.pose(chosen);
	$("follow").setAttribute("aria-pressed", camera.follows);
	picture.draw(model, chosen);
	timeline?.draw();
	showAll(model, chosen, !recording);
	if (model.navigates) loading ||= import("./navigation.js").then(({Navigation}) => navigation = new Navigation(picture, act, say, redraw), () => loading = null);
	if (chosen) navigation?.show(model, chosen, !recording);
	put("stop-which", model.list.length > 1 && "robot " + toStop());
}

function showAge(now, frame) {
	const age = !frame ? Infinity : recording ? 1000 * recording.at - frame.stamp : 1000 * frame.age + now - chosen.sent;
	const old = age > OLD && chosen, words = frame && (age / 1000).toFixed(2) + " s";
	show("old", old);
	put("old-words", old && (recording ? "NO DATA" : frame ? "OLD PICTURE:" : "NO PICTURE"));
	put("old-age", words);
	if (!old && now - ageAt < READ) return;
	put("age-text", words ? words + " old" : "none", old && "error");
	ageAt = now;
}

function storage(name) {
	try {
		return window[name];
	} catch {
		return {};
	}
}

function firstWords() {
	const session = storage("sessionStorage");
	session.word = location.hash.slice(1) || session.word || "";
	kept.visitor ||= crypto.getRandomValues(new Uint32Array(4)).join("");
	history.replaceState(null, "", location.pathname);
	return {key: session.word, visitor: kept.visitor};
}

const kept = storage("localStorage");
matchMedia("(prefers-color-scheme: dark)").onchange = dress;
$("legend").open = innerWidth > 699;
if ($("recording")) record(JSON.parse($("recording").textContent));
else live = new Live("/page", firstWords(), {text, frames, state, recorded});
onhashchange = () => live && location.hash && location.reload();
dress();	// at once
new ResizeObserver(dress).observe($("moving"));
onkeydown = onpointermove = wake;
setInterval(wake, TICK);
