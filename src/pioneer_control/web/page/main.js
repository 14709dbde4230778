// Wires all together: what comes in goes into the model, each picture is drawn from it, and only then the hand is told on.

import {Controls} from "./controls.js";
import {Deadman, Hand} from "./hand.js";
import {MapPicture} from "./map.js";
import {Model, echoesOf} from "./model.js";
import {Panel, byId, put} from "./panel.js";
import {Recording} from "./recording.js";
import {Live} from "./source.js";
import {TimeLine} from "./timeline.js";
import {Camera} from "./view.js";

const OLD = 500;            // ms: a picture older than this is called old
const SAID = 6000;          // ms that a message stays on the map
const LIMITS = [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8, 1, 1.2, 1.5, 2];      // m/s

const model = new Model(), camera = new Camera(), hand = new Hand();
const picture = new MapPicture(byId("floor"), byId("moving"), camera);
let live = null, recording = null, timeline = null, chosen = null;
let changed = true, panelAt = 0, drawnAt = performance.now(), saidAt = -Infinity, fitted = true;
const stopsToSend = new Set(), ages = [];

const deadman = new Deadman(message => send(message));
const controls = new Controls(hand, {stop: stopOrPlay, gone: () => deadman.letGo(), key: pressed});
const panel = new Panel(choose, act);

function send(message) {
  return live !== null && live.send(message);
}

function act(message) {
  if (chosen && !send({robot: chosen.number, ...message})) say("There is no connection: nothing was sent.");
}

function say(text) {
  put(byId("said"), text);
  byId("said").hidden = false;
  saidAt = performance.now();
}

// A stop that cannot go now goes as soon as it can: it never does harm.
function stop(robot) {
  controls.drop();
  if (send({do: "stop", robot})) return;
  stopsToSend.add(robot);
  say("There is no connection: STOP goes out as soon as there is one.");
}

function stopOrPlay() {
  if (timeline) timeline.toggle();
  else if (live) stop(chosen ? chosen.number : "all");
}

function choose(number) {
  if (chosen && chosen.number === number) return;
  controls.drop();
  chosen = model.list.find(robot => robot.number === number) || model.list[0] || null;
  ages.length = 0;
  changed = true;
  panelAt = 0;
  if (timeline && chosen) timeline.list(chosen.number);
}

function step(way) {
  const at = model.list.indexOf(chosen), count = model.list.length;
  if (count > 1) choose(model.list[(at + way + count) % count].number);
}

// --- What comes in ---

function text(kind, value) {
  if (kind === "recording") return void record(value);
  model.take(kind, value);
  if (kind === "hello") greet();
  if (kind === "robots") {
    const at = chosen && model.list.find(robot => robot.number === chosen.number);
    if (at !== chosen || !chosen) choose((model.list.find(robot => robot.info.yours) || model.list[0] || {}).number);
  }
  if (kind === "said") say(value.text);
  if (kind === "world" && fitted) fit();
  changed = true;
}

function greet() {
  const {title, you, teacher} = model.hello;
  document.title = title || "Robots";
  put(byId("title"), title || "Robots");
  byId("teacher").hidden = !teacher;
  if (document.activeElement !== byId("my-name")) byId("my-name").value = (you || "").replace(/ /g, "_");
}

function frames(list) {
  for (const [frame, sent] of list) if (model.all.has(frame.robot)) model.robot(frame.robot).take(frame, sent);
  changed = true;
  if (fitted && !model.world) fit();
}

function connection(state, reason) {
  const words = {open: "live", connecting: "connecting", closed: "no connection", key: "no key", refused: "refused"};
  put(byId("mode"), words[state]);
  document.body.dataset.state = state;
  if (state === "open") {
    for (const robot of stopsToSend) send({do: "stop", robot});
    stopsToSend.clear();
  } else controls.drop();
  const notice = {key: "Open this page with its whole address, as the server printed it: with # and the key at its end.",
    refused: reason, closed: reason}[state];
  byId("notice").hidden = !notice;
  put(byId("notice"), notice || "");
}

async function record(value) {
  recording = new Recording(value, model);
  timeline = new TimeLine(recording, () => picture.colour, () => chosen, () => {
    if (!model.list.includes(chosen)) choose(model.list.length ? model.list[0].number : null);
    changed = true;
  });
  document.body.classList.add("recorded");
  put(byId("mode"), "recording");
  greet();
  await recording.unpackAll();
  timeline.seek(0);
  timeline.list(chosen.number);
  changed = true;
  fit();
}

// --- The view ---

function fit() {
  camera.fit(model.bounds());
  fitted = true;
  follow(false);
}

function follow(on) {
  camera.follows = on;
  byId("follow").setAttribute("aria-pressed", String(on));
  changed = true;
}

function zoom(factor, px, py) {
  camera.zoom(factor, px, py);
  fitted = false;
  changed = true;
}

function pressed(key) {
  const action = {n: () => step(1), p: () => step(-1), f: () => follow(!camera.follows), 0: fit, "+": () => zoom(1.25),
    "=": () => zoom(1.25), "-": () => zoom(0.8), "?": openHelp, j: () => timeline && timeline.jump(-1),
    l: () => timeline && timeline.jump(1)}[key.toLowerCase()];
  if (action) action();
}

function listenMap() {
  const canvas = byId("moving"), fingers = new Map();
  let moved = 0;
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    if (fingers.size === 0) moved = 0;
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
  });
  canvas.addEventListener("pointermove", event => {
    const before = fingers.get(event.pointerId), now = [event.offsetX, event.offsetY];
    if (!before) return;
    const other = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at)[0];
    moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
    fingers.set(event.pointerId, now);
    if (moved < 6 && !other) return;
    if (other) zoom(Math.hypot(now[0] - other[0], now[1] - other[1]) / Math.max(1, Math.hypot(before[0] - other[0],
        before[1] - other[1])), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    if (!(other && camera.follows)) {
      camera.drag((now[0] - before[0]) / (other ? 2 : 1), (now[1] - before[1]) / (other ? 2 : 1));
      follow(false);
    }
    fitted = false;
  });
  canvas.addEventListener("pointerup", event => {
    const robot = moved < 6 && fingers.size === 1 ? picture.robotAt(model, event.offsetX, event.offsetY) : null;
    if (robot) choose(robot.number);
  });
  for (const name of ["pointerup", "pointercancel"])
    canvas.addEventListener(name, event => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), event.offsetX, event.offsetY);
  }, {passive: false});
  new ResizeObserver(() => {
    picture.resize();
    if (fitted) fit();
    changed = true;
  }).observe(canvas);
}

// --- Buttons ---

function openHelp() {
  controls.drop();
  byId("help").showModal();
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  picture.dress();
  if (timeline) timeline.dress();
  changed = true;
}

function raise(way) {
  const limit = (chosen && chosen.helm.limit || [0.2])[0], most = chosen ? chosen.info.max_linear || 2 : 2;
  const steps = way > 0 ? LIMITS.filter(each => each > limit + 0.001) : LIMITS.filter(each => each < limit - 0.001).reverse();
  if (steps.length) act({do: "limit", linear: Math.min(steps[0], most)});
}

function submit(form, field, message) {
  byId(form).onsubmit = event => {
    event.preventDefault();
    const words = byId(field).value.replace(/_/g, " ").trim();
    if (words && send(message(words)) && form === "say") byId(field).value = "";
    byId(field).blur();
  };
}

// A finger on STOP counts when it comes down; the click that follows is the same one.
function listenStop(id, robot) {
  let down = -Infinity;
  byId(id).addEventListener("pointerdown", event => {
    if (event.button !== 0) return;
    down = performance.now();
    stop(robot());
  });
  byId(id).addEventListener("click", () => performance.now() - down > 1000 && stop(robot()));
}

function listenButtons() {
  const click = (id, action) => byId(id).onclick = action;
  listenStop("stop", () => chosen ? chosen.number : "all");
  listenStop("stop-all", () => "all");
  click("unlock", () => act({do: "unlock"}));
  click("unlock-all", () => send({do: "unlock", robot: "all"}));
  click("take", () => act({do: "take"}));
  click("release", () => act({do: "release"}));
  click("motors-switch", () => act({do: "motors", on: byId("motors").textContent !== "on"}));
  click("slower", () => raise(-1));
  click("faster", () => raise(1));
  click("previous", () => step(-1));
  click("next", () => step(1));
  click("zoom-in", () => zoom(1.25));
  click("zoom-out", () => zoom(0.8));
  click("fit", fit);
  click("follow", () => follow(!camera.follows));
  click("help-open", openHelp);
  click("theme", () => {
    const theme = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    store(localStorage, "theme", theme);
    setTheme(theme);
  });
  submit("say", "say-text", words => ({do: "say", text: words}));
  submit("me", "my-name", words => ({do: "name", name: words}));
}

// --- Each picture ---

function ageText(ms) {
  return ms < 1000 ? `${Math.round(ms)} ms` : `${(ms / 1000).toFixed(1)} s`;
}

function showAge(now) {
  const age = !chosen || !chosen.frame ? Infinity : recording ? 1000 * recording.age(chosen)
    : 1000 * chosen.frame.age + now - chosen.sent;
  const old = age > OLD && chosen !== null;
  ages.push([now, age]);
  while (ages[0][0] < now - 500) ages.shift();                  // the worst of half a second: a number that can be read
  put(byId("age-text"), age === Infinity ? "none" : ageText(old ? age : Math.max(...ages.map(each => each[1]))) + " old");
  document.body.classList.toggle("old", old);
  byId("old").hidden = !old;
  if (!old) return void put(byId("old-words"), "");
  put(byId("old-words"), recording ? "NO DATA" : age === Infinity ? "NO PICTURE" : "OLD PICTURE");
  put(byId("old-age"), age === Infinity ? "" : ageText(age));
}

function turn() {
  requestAnimationFrame(turn);
  const now = performance.now();
  controls.poll();
  if (timeline && timeline.advance((now - drawnAt) / 1000)) changed = true;
  drawnAt = now;
  const want = hand.wants();
  if (changed || want) {
    if (camera.follows && chosen && chosen.frame) {
      const pose = model.pose(chosen);
      camera.centre(pose.x, pose.y);
    }
    picture.draw(model, chosen);
    if (timeline) timeline.draw();
  }
  if (live) tell(want, now);
  if (now - panelAt > 80 && (changed || panelAt === 0)) {
    panel.update(model, chosen, live !== null);
    panelAt = now;
    changed = false;
  } else if (now - panelAt <= 80 && changed) changed = "panel";
  showAge(now);
  if (now - saidAt > SAID) byId("said").hidden = true;
}

// Right after the drawing: what was drawn, and where the hand wants to go by this picture.
function tell(want, now) {
  live.drawn(now);
  const may = chosen && chosen.frame && chosen.info.yours !== false && !chosen.locked && !byId("help").open && live.open;
  if (want && !may) controls.drop();
  else if (chosen && chosen.frame) deadman.drawn(want, chosen.number, chosen.frame.stamp, chosen.sent, now);
}

// --- Beginning ---

// Storage may be forbidden: then nothing is kept.
function store(storage, name, value) {
  try {
    if (value !== undefined) storage.setItem(name, value);
    return storage.getItem(name);
  } catch (error) {
    return value === undefined ? null : value;
  }
}

function firstWords() {
  const fromAddress = location.hash.slice(1);
  if (fromAddress) {
    store(sessionStorage, "key", fromAddress);
    history.replaceState(null, "", location.pathname + location.search);
  }
  const made = [...crypto.getRandomValues(new Uint8Array(16))].map(each => each.toString(16).padStart(2, "0")).join("");
  return {key: fromAddress || store(sessionStorage, "key") || "",
    visitor: store(localStorage, "visitor") || store(localStorage, "visitor", made)};
}

function begin() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  setTheme(store(localStorage, "theme") || (dark.matches ? "dark" : "light"));
  dark.onchange = () => store(localStorage, "theme") || setTheme(dark.matches ? "dark" : "light");
  listenMap();
  listenButtons();
  const inside = byId("recording");
  if (inside) record(JSON.parse(inside.textContent));
  else {
    const url = location.origin.replace("http", "ws") + "/page";
    live = new Live(url, firstWords(), {text, frames, state: connection, columns: data => recording.unpackMessage(data)});
    addEventListener("hashchange", () => location.hash.length > 1 && location.reload());
  }
  requestAnimationFrame(turn);
}

begin();
