// The time line of a recording: speed over time, marks, and where we are; to play, to seek, to jump.

import {FONT, colours, sized} from "./map.js";
import {$, items, make, put, show} from "./panel.js";

const SIGNS = {fault: ["▲", "bad"], decision: ["╵", "ink2"], event: ["◆", "goal"]};
const EDGE = 8;		// pixels: half of the thumb of a slider

function clockText(at) {
	const tenths = Math.round(10 * at);
	return `${Math.floor(tenths / 600)}:${String(Math.floor(tenths / 10) % 60).padStart(2, "0")}.${tenths % 10}`;
}

export class TimeLine {
	// changed() is called when the time is another one.
	constructor(recording, changed) {
		Object.assign(this, {recording, changed, playing: false});
		$("line").max = Math.ceil(recording.duration);
		$("line").oninput = () => this.seek(Number($("line").value));
	}

	toggle() {
		if (!this.playing && this.recording.at >= this.recording.duration) this.seek(0);
		this.playing = !this.playing;
		$("play").textContent = this.playing ? "❚❚" : "▶";
		$("play").ariaLabel = this.playing ? "Pause" : "Play";
	}

	seek(at) {
		this.recording.seek(at);
		this.changed();
	}

	jump(way) {
		const ahead = mark => way * (mark.at - this.recording.at) > 0.05, mark = way > 0 ? this.marks.find(ahead) : this.marks.findLast(ahead);
		if (mark) this.go(mark);
	}

	go(mark) {
		this.seek(mark.at);
		put("mark-text", mark.text);
	}

	advance(seconds) {
		if (!this.playing) return;
		this.seek(this.recording.at + parseFloat($("rate").value) * seconds);
		if (this.recording.at >= this.recording.duration) this.toggle();
	}

	// The size or the robot is another one.
	dress(number) {
		const {recording} = this, canvas = $("curve"), marks = recording.marksOf(number);
		Object.assign(this, {marks, ctx: sized(canvas), colour: colours(), speeds: recording.speeds(number, canvas.clientWidth)});
		show("marks", marks.length);
		items($("mark-list"), marks.slice(0, 500), (item, mark) =>
			make(item, "button", `${clockText(mark.at)} ${(SIGNS[mark.kind] || SIGNS.event)[0]} ${mark.text}`).onclick = () => this.go(mark));
	}

	draw() {
		const {ctx, colour, speeds, recording: {at, duration}} = this, {clientWidth: wide, clientHeight: high} = $("curve");
		const x = time => EDGE + time / duration * (wide - 2 * EDGE), most = Math.max(0.1, ...speeds.map(each => Math.abs(each[1])));
		const zero = (high + 14) / 2, y = speed => zero - speed / most * (high / 2 - 12);
		ctx.clearRect(0, 0, wide, high);
		ctx.fillStyle = colour.line;
		ctx.fillRect(EDGE, zero, wide - 2 * EDGE, 1);
		Object.assign(ctx, {strokeStyle: colour.program, lineWidth: 1.75, font: "11" + FONT}).beginPath();
		for (const [time, speed] of speeds) ctx.lineTo(x(time), y(speed));
		ctx.stroke();
		for (const mark of this.marks) {
			const [sign, ink] = SIGNS[mark.kind] || SIGNS.event;
			ctx.fillStyle = colour[ink];
			ctx.fillText(sign, x(mark.at), 8);
		}
		ctx.fillStyle = colour.ink;
		ctx.fillRect(x(at) - 1.5, 0, 3, high);
		put("clock", `${clockText(at)} of ${clockText(duration)}`);
		Object.assign($("line"), {value: at, ariaValueText: clockText(at)});
	}
}
