// The time line of a recording: speeds and battery over time, marks, and where we are; to play, to seek, to jump.

import {colours, sized} from "./map.js";
import {byId, items, put} from "./panel.js";

const SIGNS = {fault: ["▲", "bad"], decision: ["╵", "ink2"], event: ["◆", "goal"]};
const CURVES = [["linear", "Forward", "m/s", "program"], ["angular", "Turn left", "rad/s", "cone"], ["battery", "Battery", "V", "person"]];
const LEFT = 132, RIGHT = 12, TOP = 18;		// pixels around the curves

export function clockText(at) {
	const tenths = Math.round(10 * at);
	return `${Math.floor(tenths / 600)}:${String(Math.floor(tenths / 10) % 60).padStart(2, "0")}.${tenths % 10}`;
}

export class TimeLine {
	// changed() is called when the time is another one.
	constructor(recording, changed) {
		const canvas = byId("line");
		Object.assign(this, {recording, changed, canvas, playing: false, rate: 1, number: null});
		for (const rate of [0.1, 0.2, 0.5, 1, 2, 5, 10, 20]) byId("rate").append(new Option(rate + "×", rate, rate === 1, rate === 1));
		byId("rate").onchange = event => this.rate = Number(event.target.value);
		byId("play").onclick = () => this.toggle();
		byId("mark-previous").onclick = () => this.jump(-1);
		byId("mark-next").onclick = () => this.jump(1);
		canvas.onpointerdown = canvas.onpointermove = event => {
			if (!event.buttons) return;
			canvas.setPointerCapture(event.pointerId);
			this.seek((event.offsetX - LEFT) / (canvas.clientWidth - LEFT - RIGHT) * recording.duration);
		};
		canvas.onkeydown = event => {
			const {at, duration} = recording, step = event.shiftKey ? 10 : 1;
			const to = {ArrowLeft: at - step, ArrowRight: at + step, ArrowDown: at - step, ArrowUp: at + step, PageDown: at - 30,
				PageUp: at + 30, Home: 0, End: duration}[event.key];
			if (to === undefined) return;
			event.preventDefault();
			this.seek(to);
		};
		new ResizeObserver(() => this.show(this.number)).observe(canvas);
	}

	toggle() {
		if (!this.playing && this.recording.at >= this.recording.duration) this.seek(0);
		this.playing = !this.playing;
		byId("play").textContent = this.playing ? "⏸" : "▶";
		byId("play").ariaLabel = (this.playing ? "Pause" : "Play") + " (space bar)";
	}

	seek(at) {
		this.recording.seek(at);
		this.changed();
	}

	jump(way) {
		const {at} = this.recording, marks = this.recording.marksOf(this.number);
		const mark = way > 0 ? marks.find(each => each.at > at + 0.05) : marks.reverse().find(each => each.at < at - 0.05);
		if (mark) this.go(mark);
	}

	go(mark) {
		this.seek(mark.at);
		put("mark-text", mark.text);
	}

	advance(seconds) {
		if (!this.playing) return;
		this.seek(this.recording.at + this.rate * seconds);
		if (this.recording.at >= this.recording.duration) this.toggle();
	}

	x(at) {
		return LEFT + at / Math.max(0.001, this.recording.duration) * (this.canvas.clientWidth - LEFT - RIGHT);
	}

	// Shows a robot: all but the moment of now is painted once.
	show(number) {
		const {recording, canvas} = this, wide = canvas.clientWidth, strip = (canvas.clientHeight - TOP - 2) / CURVES.length;
		this.number = number;
		this.painted = document.createElement("canvas");
		const ctx = sized(this.painted, wide, canvas.clientHeight), colour = colours(), marks = recording.marksOf(number);
		this.ctx = sized(canvas, wide, canvas.clientHeight);
		this.ink = colour.ink;
		Object.assign(ctx, {font: '11px system-ui, "DejaVu Sans", sans-serif', textBaseline: "middle", lineJoin: "round"});
		CURVES.forEach(([name, title, unit, ink], i) => {
			const curve = recording.curve(number, name, wide), values = curve.map(each => each[1]), top = TOP + i * strip;
			const most = name === "battery" ? Math.max(...values) + 0.1 : Math.max(0.1, ...values.map(Math.abs));
			const least = name === "battery" ? Math.min(...values) - 0.1 : -most, y = value => top + 4 + (most - value) / (most - least) * (strip - 8);
			ctx.fillStyle = colour.ink2;
			ctx.textAlign = "left";
			ctx.fillText(title, 4, top + strip / 2);
			ctx.textAlign = "right";
			if (values.length) ctx.fillText(`${most.toFixed(1)} ${unit}`, LEFT - 8, top + 8);
			if (values.length) ctx.fillText(least.toFixed(1), LEFT - 8, top + strip - 8);
			Object.assign(ctx, {strokeStyle: colour.line, lineWidth: 1});
			ctx.strokeRect(LEFT + 0.5, Math.round(top) + 0.5, wide - LEFT - RIGHT, strip - 1);
			Object.assign(ctx, {strokeStyle: colour[ink], lineWidth: 1.75});
			ctx.beginPath();
			for (const [at, value] of curve) ctx.lineTo(this.x(at), y(value));
			ctx.stroke();
		});
		ctx.textAlign = "center";
		for (const {kind, at} of marks) {
			const [sign, ink] = SIGNS[kind] || SIGNS.event;
			ctx.fillStyle = colour[ink];
			ctx.fillText(sign, this.x(at), TOP - 7);
		}
		byId("marks").hidden = marks.length === 0;
		items(byId("mark-list"), marks.slice(0, 500), (item, mark) => {
			const button = document.createElement("button");
			button.textContent = `${clockText(mark.at)} ${(SIGNS[mark.kind] || SIGNS.event)[0]} ${mark.text}`;
			button.onclick = () => this.go(mark);
			item.append(button);
		});
		this.draw();
	}

	draw() {
		const {ctx, canvas, recording} = this, x = this.x(recording.at), high = canvas.clientHeight;
		const text = `${clockText(recording.at)} of ${clockText(recording.duration)}`;
		ctx.clearRect(0, 0, canvas.clientWidth, high);
		ctx.drawImage(this.painted, 0, 0, canvas.clientWidth, high);
		ctx.fillStyle = this.ink;
		ctx.fillRect(x - 1, 0, 2, high);
		ctx.beginPath();
		ctx.arc(x, 6, 6, 0, 7);
		ctx.fill();
		put("clock", text);
		Object.assign(canvas, {ariaValueMax: recording.duration, ariaValueNow: recording.at.toFixed(1), ariaValueText: text});
	}
}
