// The time line of a recording: speeds and battery over time, marks, and where we are; to play, to seek, to jump.

import {FONT, colours, sized} from "./map.js";
import {$, items, make, put, show} from "./panel.js";

const SIGNS = {fault: ["▲", "bad"], decision: ["╵", "ink2"], event: ["◆", "goal"]};
const CURVES = [["linear", "Forward", "m/s", "program"], ["angular", "Turn left", "rad/s", "cone"], ["battery", "Battery", "V", "person"]];
const LEFT = 132, TOP = 18;		// pixels beside and above the curves

export function clockText(at) {
	const tenths = Math.round(10 * at);
	return `${Math.floor(tenths / 600)}:${String(Math.floor(tenths / 10) % 60).padStart(2, "0")}.${tenths % 10}`;
}

export class TimeLine {
	// changed() is called when the time is another one.
	constructor(recording, changed) {
		const canvas = $("line"), {duration} = recording;
		Object.assign(this, {recording, changed, canvas, playing: false});
		for (const rate of [0.1, 0.2, 0.5, 1, 2, 5, 10, 20]) $("rate").append(new Option(rate + "×", rate, rate === 1, rate === 1));
		canvas.onpointerdown = canvas.onpointermove = event => {
			if (!event.buttons) return;
			canvas.setPointerCapture(event.pointerId);
			this.seek((event.offsetX - LEFT) / (canvas.clientWidth - LEFT - 12) * duration);
		};
		canvas.onkeydown = ({key, shiftKey}) => {
			const step = shiftKey ? 10 : 1, steps = {ArrowLeft: -step, ArrowRight: step, ArrowDown: -step, ArrowUp: step, PageDown: -30, PageUp: 30,
				Home: -duration, End: duration};
			if (steps[key]) this.seek(recording.at + steps[key]);
		};
	}

	toggle() {
		if (!this.playing && this.recording.at >= this.recording.duration) this.seek(0);
		this.playing = !this.playing;
		$("play").textContent = this.playing ? "❚❚" : "▶";
		$("play").ariaLabel = (this.playing ? "Pause" : "Play") + " (space bar)";
	}

	seek(at) {
		this.recording.seek(at);
		this.changed();
	}

	jump(way) {
		const marks = this.recording.marksOf(this.number), ahead = mark => way * (mark.at - this.recording.at) > 0.05;
		const mark = way > 0 ? marks.find(ahead) : marks.reverse().find(ahead);
		if (mark) this.go(mark);
	}

	go(mark) {
		this.seek(mark.at);
		put("mark-text", mark.text);
	}

	advance(seconds) {
		if (!this.playing) return;
		this.seek(this.recording.at + $("rate").value * seconds);
		if (this.recording.at >= this.recording.duration) this.toggle();
	}

	x(at) {
		return LEFT + at / Math.max(0.001, this.recording.duration) * (this.canvas.clientWidth - LEFT - 12);
	}

	// Shows a robot: all but the moment of now is painted once.
	show(number) {
		const {recording, canvas} = this, {clientWidth: wide, clientHeight: high} = canvas, strip = (high - TOP - 2) / CURVES.length;
		Object.assign(this, {number, painted: document.createElement("canvas"), ctx: sized(canvas, wide, high)});
		const ctx = sized(this.painted, wide, high), colour = colours(), marks = recording.marksOf(number);
		const write = (text, x, y, ink, textAlign) => {
			Object.assign(ctx, {fillStyle: colour[ink], textAlign, font: "11" + FONT, textBaseline: "middle"});
			ctx.fillText(text, x, y);
		};
		CURVES.forEach(([name, title, unit, ink], i) => {
			const curve = recording.curve(number, name, wide), values = curve.map(each => each[1]), top = TOP + i * strip, battery = name === "battery";
			const most = battery ? Math.max(...values) + 0.1 : Math.max(0.1, ...values.map(Math.abs)), least = battery ? Math.min(...values) - 0.1 : -most;
			write(title, 4, top + strip / 2, "ink2", "left");
			if (values.length && strip > 24) write(`${most.toFixed(1)} ${unit}`, LEFT - 8, top + 8, "ink2", "right");
			if (values.length && strip > 24) write(least.toFixed(1), LEFT - 8, top + strip - 8, "ink2", "right");
			ctx.strokeStyle = colour.line;
			ctx.strokeRect(LEFT + 0.5, Math.round(top) + 0.5, wide - LEFT - 12, strip - 1);
			Object.assign(ctx, {strokeStyle: colour[ink], lineWidth: 1.75}).beginPath();
			for (const [at, value] of curve) ctx.lineTo(this.x(at), top + 4 + (most - value) / (most - least) * (strip - 8));
			ctx.stroke();
		});
		for (const {kind, at} of marks) write((SIGNS[kind] || SIGNS.event)[0], this.x(at), TOP - 7, (SIGNS[kind] || SIGNS.event)[1], "center");
		this.ink = colour.ink;
		show("marks", marks.length);
		items($("mark-list"), marks.slice(0, 500), (item, mark) =>
			make(item, "button", `${clockText(mark.at)} ${(SIGNS[mark.kind] || SIGNS.event)[0]} ${mark.text}`).onclick = () => this.go(mark));
		this.draw();
	}

	draw() {
		const {ctx, canvas, painted, recording: {at, duration}} = this, {clientWidth: wide, clientHeight: high} = canvas, x = this.x(at);
		if (!ctx) return;
		ctx.clearRect(0, 0, wide, high);
		ctx.drawImage(painted, 0, 0, wide, high);
		Object.assign(ctx, {fillStyle: this.ink}).fillRect(x - 1, 0, 2, high);
		ctx.beginPath();
		ctx.arc(x, 6, 6, 0, 7);
		ctx.fill();
		put("clock", `${clockText(at)} of ${clockText(duration)}`);
		Object.assign(canvas, {ariaValueMax: duration, ariaValueNow: at.toFixed(1), ariaValueText: clockText(at)});
	}
}
