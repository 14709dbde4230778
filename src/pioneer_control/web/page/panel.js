// The words beside the map: the chosen robot, the list of all, and what the server said. Only texts, never markup.

import {FLAG, GRIP} from "./frames.js";
import {stateOf} from "./model.js";

const GRIPS = ["open", "close", "up", "down", "deploy", "store", "stop"];

export function byId(id) {
  return document.getElementById(id);
}

// Changes nothing that is as it should be: so a screen reader speaks only of what changed.
export function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function show(element, shown) {
  if (element.hidden === shown) element.hidden = !shown;
}

function paint(element, kind) {
  if (element.dataset.kind !== kind) element.dataset.kind = kind;
}

function fill(list, texts, make) {
  const key = JSON.stringify(texts);
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...texts.map(text => {
    const item = document.createElement("li");
    make(item, text);
    return item;
  }));
}

function pair(robot, left, right, names, none) {
  const found = [robot.is(left) && names[0], robot.is(right) && names[1]].filter(each => each);
  return found.length ? found.join(" and ") : none;
}

function gripText(state) {
  const words = [];
  if (state & GRIP.holding) words.push("holds something");
  words.push(state & GRIP.moving ? "moving" : state & GRIP.open ? "open" : state & GRIP.closed ? "closed" : "half open");
  if (state & GRIP.lifting) words.push("lift moving");
  else if (state & GRIP.up) words.push("up");
  else if (state & GRIP.down) words.push("down");
  return words.join(", ");
}

function turnText(angular) {
  const degrees = Math.round(Math.abs(angular) * 180 / Math.PI);
  return degrees ? `${degrees} °/s ${angular > 0 ? "left" : "right"}` : "0 °/s";
}

function batteryText({volts, charge, level}) {
  return `${volts.toFixed(1)} V` + (charge === null || charge === undefined ? "" : ` · ${Math.round(100 * charge)} %`) +
    (level === "ok" ? "" : level === "warn" ? " · low" : " · empty");
}

// Who drives, and what may be done about it.
function drivers(robot) {
  const {helm} = robot, locks = helm.locks || [];
  if (robot.locked) return ["■", "Locked: " + (locks.join(", ") || "it takes no commands"), "Nothing moves until somebody unlocks."];
  const programs = {driving: "", free: "Programs may command.", "locked out": "Programs are locked out."}[helm.programs] || "";
  if (helm.commander === "person") return ["◆", helm.you ? "You drive" : `${helm.who || "Somebody"} drives`, programs];
  if (helm.commander === "program") return ["▶", "A program drives", "Take the helm to drive by hand."];
  return ["○", "Nobody drives", programs];
}

export class Panel {
  // choose(robot) is called for a click in the list, act(message) for a button.
  constructor(choose, act) {
    Object.assign(this, {choose, act, tiles: new Map()});
    for (const command of GRIPS) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = command;
      button.onclick = () => act({do: "gripper", command});
      byId("grip").append(button);
    }
  }

  update(model, robot, live) {
    this.updateList(model, robot);
    fill(byId("log-list"), model.log.slice(-8), (item, said) => {
      item.dataset.kind = said.level;
      item.textContent = (said.robot === null || said.robot === undefined ? "" : said.robot + ": ") + said.text +
        (said.times > 1 ? ` (${said.times} times)` : "");
    });
    show(byId("previous"), model.list.length > 1);
    show(byId("next"), model.list.length > 1);
    document.body.classList.toggle("empty", !robot);
    if (robot) this.updateRobot(robot, live);
  }

  updateRobot(robot, live) {
    const {info, frame, status, helm} = robot, [kind] = stateOf(robot), text = (id, words) => put(byId(id), words);
    text("number", String(robot.number));
    paint(byId("number"), kind);
    text("name", info.name);
    text("model", info.model + (info.simulated ? " · simulated" : ""));
    byId("model").title = info.where || "";
    const [sign, driver, note] = drivers(robot);
    text("driver-sign", sign);
    text("driver-text", driver);
    text("driver-note", live && info.yours === false ? "You may look, but not drive this one." : live ? note : "");
    paint(byId("helm"), kind);
    const mine = live && info.yours !== false, locked = (helm.locks || []).length > 0;
    show(byId("unlock"), mine && locked);
    show(byId("take"), mine && !locked && ["driving", "free"].includes(helm.programs));
    show(byId("release"), mine && !locked && helm.programs === "locked out");
    const decision = status.decision;
    show(byId("decision"), Boolean(decision));
    if (decision) {
      text("doing", decision.doing);
      text("why", decision.why ? "because " + decision.why : "");
    }
    fill(byId("faults"), robot.faults, (item, fault) => {
      item.dataset.kind = fault.level;
      const task = document.createElement("b");
      task.textContent = fault.task;
      item.append(fault.level === "error" ? "✖ " : "▲ ", task, " ", fault.text);
    });
    if (!frame) return;
    text("linear", `${frame.linear.toFixed(2)} m/s`);
    text("angular", turnText(frame.angular));
    text("battery", (status.battery ? batteryText(status.battery) : "not known") + (robot.is(FLAG.charging) ? " · charging" : ""));
    paint(byId("battery"), (status.battery || {}).level || "");
    text("motors", robot.is(FLAG.motors) ? "on" : "off");
    text("wheels", pair(robot, FLAG.stallLeft, FLAG.stallRight, ["left", "right"], "free"));
    put(byId("wheels").previousElementSibling, robot.is(FLAG.stallLeft | FLAG.stallRight) ? "Stalled wheels" : "Wheels");
    text("bumpers", pair(robot, FLAG.bumpFront, FLAG.bumpRear, ["front", "rear"], "free"));
    put(byId("bumpers").previousElementSibling, robot.is(FLAG.bumpFront | FLAG.bumpRear) ? "Bumped" : "Bumpers");
    text("button", robot.is(FLAG.button) ? "pressed" : "free");
    paint(byId("wheels"), robot.is(FLAG.stallLeft | FLAG.stallRight) ? "error" : "");
    paint(byId("bumpers"), robot.is(FLAG.bumpFront | FLAG.bumpRear) ? "error" : "");
    paint(byId("button"), robot.is(FLAG.button) ? "error" : "");
    const fitted = (frame.gripper & GRIP.fitted) !== 0;
    show(byId("gripper-cell"), fitted);
    if (fitted) text("gripper", gripText(frame.gripper));
    const counts = status.counts, link = status.link || "ok";
    text("link", (link === "ok" ? "works" : link) + (counts ? ` · ${counts.sips_per_second.toFixed(0)} packets/s` +
      (counts.bad_checksums ? `, ${counts.bad_checksums} damaged` : "") +
      (counts.reconnects ? `, ${counts.reconnects} times anew` : "") : ""));
    paint(byId("link"), link === "ok" ? "" : "error");
    show(byId("controls"), mine);
    show(byId("grip"), fitted && Boolean(info.gripper));
    text("motors-switch", robot.is(FLAG.motors) ? "Switch motors off" : "Switch motors on");
    text("limit-text", helm.limit ? `${helm.limit[0].toFixed(2)} m/s` : "–");
    text("hint", !mine ? "" : robot.locked ? "locked: unlock above" : !robot.is(FLAG.motors) ? "motors are off" :
      helm.programs === "driving" ? "a program drives" : "hold arrows or the stick");
  }

  updateList(model, chosen) {
    show(byId("list"), model.list.length > 1 || Boolean(model.hello.teacher));
    document.body.classList.toggle("many", !byId("list").hidden);
    const numbers = model.list.map(robot => robot.number);
    fill(byId("tiles"), numbers, (item, number) => {
      const button = document.createElement("button"), parts = {};
      for (const part of ["number", "sign", "state", "name", "volts"]) {
        parts[part] = document.createElement("span");
        parts[part].className = part;
        button.append(parts[part]);
      }
      button.type = "button";
      button.onclick = () => this.choose(number);
      item.append(button);
      this.tiles.set(number, {button, parts});
    });
    for (const robot of model.list) {
      const {button, parts} = this.tiles.get(robot.number), [kind, sign, word] = stateOf(robot), {battery} = robot.status;
      paint(button, kind);
      put(parts.number, String(robot.number));
      put(parts.sign, sign);
      put(parts.state, word);
      put(parts.name, robot.info.name);
      put(parts.volts, battery ? `${battery.volts.toFixed(1)} V${battery.level === "ok" ? "" : " low"}` : "");
      const pressed = String(robot === chosen);
      if (button.getAttribute("aria-pressed") === pressed) continue;
      button.setAttribute("aria-pressed", pressed);
      if (robot === chosen) button.scrollIntoView({block: "nearest", inline: "nearest"});
    }
  }
}
