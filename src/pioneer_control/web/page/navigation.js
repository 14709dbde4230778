// Navigation: where a robot may be and how it means to go, and the hand that sends it. Loaded when a robot has it:
// main.js knows nothing of what is here. What is not on the page yet is made here, and so are its rules of style.

import {$, make, put, show} from "./panel.js";

const SHORT = 14;		// pixels: a shorter drag is a click; a click so near a place means the place
const SIGN = 20;		// pixels from a place up to the middle of its name
const DONE = {idle: "○ No goal", driving: "▶ Drives", waiting: "❚❚ Waits", reached: "✔ Is there", failed: "✖ Gave up", silent: "? Silent"};
const HINTS = {
	go: "Click where it is to go. Drag to say where it looks then.",
	here: "Press where the robot is, and drag to where it looks.",
};
const LOOK = [
	"#travel{border-width:1px;border-left:6px solid var(--goal);border-radius:10px;padding:8px 12px}",
	"#travel :is(#cancel,summary,form){margin:8px 0 0}",
	"#travel input,#travel select{width:100%}",
	"#travel form:nth-of-type(2){grid-template-columns:repeat(6,minmax(0,1fr))}",
	"#travel form:nth-of-type(2) label{grid-column:span 2}",
	"#travel form:nth-of-type(2) button{grid-column:span 3}",
	"#tools{flex-wrap:wrap;justify-content:flex-end}",
	"main #aim{top:9px;bottom:auto;z-index:1}",
	"#moving + canvas{pointer-events:none}",
	"@media (max-width:699px){#zoom-in,#zoom-out{display:none}}",
];

export class Navigation {
	// act(order, fields): sends an order for the chosen robot. say(text). redraw()
	constructor(picture, act, say, redraw) {
		const layer = document.createElement("canvas"), [, moving] = picture.canvases, [sheet] = document.styleSheets;
		Object.assign(this, {picture, act, say, redraw, moving, mode: null, robot: null, drag: null, fingers: new Set(), places: []});
		for (const rule of LOOK) sheet.insertRule(rule, sheet.cssRules.length);
		moving.after(layer);
		picture.canvases.push(layer);
		picture.dress();
		this.build();
		this.listen();
		redraw();
	}

	build() {
		const travel = document.createElement("div"), tools = $("tools");
		$("helm").after(travel);
		travel.id = "travel";
		make(travel, "b", {id: "travel-state", role: "status"});
		make(travel, "p", {id: "travel-why"});
		make(travel, "p", {id: "travel-sure", role: "status"});
		make(travel, "button", {id: "cancel", name: "cancel", textContent: "Cancel goal"});
		const more = make(travel, "details", {id: "travel-more"}), [first, second, third] = [0, 1, 2].map(() => make(more, "form"));
		more.prepend(make(more, "summary", {textContent: "Places, and places by numbers"}));
		make(first, "select", {id: "places", ariaLabel: "Place"});
		make(first, "button", {value: "go", textContent: "Go to it"});
		make(first, "button", {value: "forget_place", textContent: "Forget its name"});
		for (const [id, words] of [["to-x", "x (m)"], ["to-y", "y (m)"], ["to-turn", "looks (°)"]])
			make(make(second, "label", {textContent: words}), "input", {id, type: "number", step: "any", required: true});
		make(second, "button", {value: "go", textContent: "Go there"});
		make(second, "button", {value: "here", textContent: "It is there"});
		make(third, "input", {id: "place-name", placeholder: "name, _ for a space", ariaLabel: "Name of the place", maxLength: 40, required: true, autocomplete: "off"});
		make(third, "button", {textContent: "Name the place where it is"});
		for (const [id, letter, words] of [["go", "G", "Go"], ["here", "H", "Here"]])
			make(tools, "button", {id, textContent: words, onclick: () => this.aim(this.mode === id ? null : id)}).setAttribute("aria-keyshortcuts", letter);
		tools.prepend($("go"), $("here"));
		make(this.moving.parentElement, "p", {id: "aim", role: "status"});
		for (const [key, words] of [["G H", "send the robot; say where it is"], ["Esc", "give up the click"]])
			$("help").querySelector("dl").append(Object.assign(document.createElement("dt"), {textContent: key}), Object.assign(document.createElement("dd"), {textContent: words}));
		$("legend").append(document.createElement("br"), "purple pin: place, line: its plan; black strokes: where it may be");
		$("to-x").placeholder = $("to-y").placeholder = $("to-turn").placeholder = "0";
		first.onsubmit = event => this.submit(event, value => this.choosePlace(value));
		second.onsubmit = event => this.submit(event, value => {
			const [x, y, turn] = ["to-x", "to-y", "to-turn"].map(id => $(id).valueAsNumber);
			this.tell(value, [x, y, turn * Math.PI / 180]);
		});
		third.onsubmit = event => this.submit(event, () => {
			this.act("save_place", {name: $("place-name").value.replace(/_/g, " ").trim()});
			$("place-name").value = "";
		});
	}

	submit(event, send) {
		event.preventDefault();
		send(event.submitter?.value);
		document.activeElement.blur();
	}

	choosePlace(what) {
		const chosen = this.places.find(([name]) => name === $("places").value);
		if (!chosen) return this.say("No place has a name yet.");
		if (what === "go") this.tell("go", chosen.slice(1));
		else this.act("forget_place", {name: chosen[0]});
	}

	tell(order, [x, y, heading]) {
		const [east, north, turn] = [x, y, Math.atan2(Math.sin(heading), Math.cos(heading))].map(each => Number(each.toFixed(3)));
		this.act(order, {x: east, y: north, heading: turn});
		this.aim(null);
	}

	aim(mode) {
		const locked = mode === "go" && this.robot?.helm.programs === "locked out";
		if (locked) this.say("A person has the helm: click “Let programs drive” first.");
		this.mode = locked ? null : mode;
		this.drag = null;
		for (const each of ["go", "here"]) $(each).setAttribute("aria-pressed", this.mode === each);
		put("aim", HINTS[this.mode]);
		this.moving.style.cursor = this.mode ? "crosshair" : "";
		this.redraw();
	}

	// While it aims, a finger on the map is for that alone: the view does not hear of it.
	listen() {
		const area = this.moving.parentElement, at = event => [event.offsetX, event.offsetY];
		const hear = (kind, take) => area.addEventListener(kind, event => {
			if (event.target !== this.moving || !(this.mode || this.fingers.has(event.pointerId))) return;
			event.stopPropagation();
			take(event);
			this.redraw();
		}, true);
		hear("pointerdown", event => {
			this.fingers.add(event.pointerId);
			this.moving.setPointerCapture(event.pointerId);
			this.drag = this.fingers.size > 1 || event.button ? null : {id: event.pointerId, from: at(event), to: at(event)};
		});
		hear("pointermove", event => {
			if (event.pointerId === this.drag?.id) this.drag.to = at(event);
		});
		hear("pointerup", event => {
			this.fingers.delete(event.pointerId);
			if (event.pointerId === this.drag?.id) this.release(this.drag);
		});
		hear("pointercancel", event => {
			this.fingers.delete(event.pointerId);
			this.drag = null;
		});
		addEventListener("keydown", event => {
			if (event.key === "Escape" && this.mode) this.aim(null);
		}, true);
	}

	release({from, to}) {
		const {camera} = this.picture, [x, y] = camera.toWorld(from), dragged = lengthOf(from, to) > SHORT;
		this.drag = null;
		const near = this.places.find(([, ...spot]) => lengthOf(camera.toScreen(spot), from) < SHORT) || this.places.findLast(place => this.onName(place, from));
		if (dragged) this.tell(this.mode, [x, y, Math.atan2(from[1] - to[1], to[0] - from[0])]);
		else if (this.mode === "here") this.say("Drag from where it is to where it looks.");
		else if (near) this.tell("go", near.slice(1));
		else this.tell("go", [x, y, Math.atan2(y - this.pose[1], x - this.pose[0])]);
	}

	onName([name, ...spot], [x, y]) {
		const {camera, ctx} = this.picture, [left, low] = camera.toScreen(spot);
		return Math.abs(x - left) < ctx.measureText(name).width / 2 + 7 && Math.abs(y - low + SIGN) < 10;
	}

	show(model, robot, live) {
		const {navigation: {state, reason = "", sure, unsure = "", goal}, places: {places = []}, info} = robot, mine = live && info.yours !== false;
		const may = mine && state && state !== "silent" && !document.body.matches(".theirs"), name = nameOf(goal, places);
		Object.assign(this, {places, pose: robot.frame ? model.pose(robot) : [0, 0, 0]});
		if (this.mode && (!may || robot !== this.robot)) this.aim(null);
		this.robot = robot;
		show("travel", state);
		put("travel-state", (DONE[state] || state) + (name ? ": " + name : ""), {failed: "error", waiting: "warn", silent: "error"}[state]);
		put("travel-why", reason !== state && reason);
		put("travel-sure", sure ? "It knows where it is." : reason.includes(unsure) ? "" : unsure, sure || "warn");
		show("cancel", mine && goal);
		for (const id of ["go", "here", "travel-more"]) show(id, may);
		const options = places.map(([each]) => each);
		if (options.join("\n") !== this.options) {
			$("places").replaceChildren(...options.map(each => new Option(each)));
			this.options = options.join("\n");
		}
		this.draw(model, robot);
	}

	draw(model, robot) {
		const {picture, drag, mode, places, pose} = this, {camera} = picture, {navigation, plan: {points = []}, cloud: {poses = []}} = robot, pixel = 1 / camera.scale;
		picture.onCanvas(2, () => {
			picture.path(...points).stroke("goal", 4, 0.7);
			for (const [x, y, heading] of poses) picture.path([x, y], ahead([x, y, heading], 9 * pixel)).stroke("ink", 1.5, 0.6).disc([x, y], 2 * pixel).fill("ink", 0.6);
			for (const [, ...spot] of places) picture.disc(spot, 5 * pixel).fill("goal").path(spot.slice(0, 2), ahead(spot, 13 * pixel)).stroke("goal", 3);
			for (const goal of Object.values(model.goals)) picture.disc(goal, 9 * pixel).stroke("goal", 3).disc(goal, 4 * pixel).fill("goal");
			if (navigation.goal) picture.path(ahead(navigation.goal, 9 * pixel), ahead(navigation.goal, 24 * pixel)).stroke("goal", 4);
			if (drag) picture.disc(camera.toWorld(drag.from), 9 * pixel).stroke(mode === "go" ? "goal" : "person", 3).path(camera.toWorld(drag.from), camera.toWorld(drag.to)).stroke(mode === "go" ? "goal" : "person", 4);
		});
		for (const [name, ...spot] of places) picture.plate(name, spot, SIGN, "goal");
		for (const [number, goal] of Object.entries(model.goals)) picture.plate("goal " + number, goal, -22, "goal");
		if (navigation.sure === false && robot.frame) picture.plate("not sure where", pose, -40, "warn");
	}
}

function lengthOf(one, other) {
	return Math.hypot(one[0] - other[0], one[1] - other[1]);
}

function ahead([x, y, heading], far) {
	return [x + far * Math.cos(heading), y + far * Math.sin(heading)];
}

function nameOf(goal, places) {
	return goal && places.find(([, x, y]) => lengthOf(goal, [x, y]) < 0.05)?.[0];
}
