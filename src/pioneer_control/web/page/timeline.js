// The time line of a recording: speed and marks; play, seek, jump.

import {colours, sized} from "./map.js";
import {$, clockText, put} from "./panel.js";

const SIGNS = {fault: "▲", decision: "╵", event: "◆"};
const EDGE = 8;		// pixels: half of the thumb of a slider

export class TimeLine {
	constructor(recording, changed) {
		Object.assign(this, {recording, changed, playing: false});
		$("line").max = Math.ceil(recording.duration);
		$("line").oninput = () => this.seek(+$("line").value);
	}

	toggle() {
		if (!this.playing && this.recording.at >= this.recording.duration) this.seek(0);
		this.playing = !this.playing;
		Object.assign($("play"), this.playing ? {textContent: "❚❚", ariaLabel: "Pause"} : {textContent: "▶", ariaLabel: "Play"});
	}

	seek(at) {
		this.recording.seek(at);
		this.changed();
	}

	jump(way) {
		const mark = this.marks[way > 0 ? "find" : "findLast"](({at}) => way * (at - this.recording.at) > 0.05);
		if (mark) this.seek(mark.at);
		put("mark-text", mark?.text);
	}

	advance(seconds) {
		if (!this.playing) return;
		this.seek(this.recording.at + parseFloat($("rate").value) * seconds);
		if (this.recording.at >= this.recording.duration) this.toggle();
	}

	dress(number) {
		const {marks, unpacked} = this.recording;
		Object.assign(this, {ctx: sized($("curve")), colour: colours(), columns: unpacked.get(number),
			marks: marks.filter(mark => (mark.robot ?? number) === number)});
	}

	draw() {
		const {ctx, colour, recording: {at, duration}, columns: {rows = 0, time, linear} = {}} = this;
		const {clientWidth: wide, clientHeight: high} = $("curve"), x = seconds => EDGE + seconds / duration * (wide - 2 * EDGE);
		const zero = high / 2 + 7, most = linear?.reduce((found, each) => Math.max(found, Math.abs(each)), 100);
		ctx.clearRect(0, 0, wide, high);
		ctx.fillStyle = colour.line;
		ctx.fillRect(EDGE, zero, wide - 2 * EDGE, 1);
		Object.assign(ctx, {strokeStyle: colour.program, lineWidth: 1.5}).beginPath();
		for (let row = 0; row < rows; row += Math.ceil(rows / 4000)) ctx.lineTo(x(time[row] / 1000), zero - linear[row] / most * (high / 2 - 10));
		ctx.stroke();
		for (const {kind, at} of this.marks) {
			ctx.fillStyle = colour[kind === "fault" ? "error" : "ink2"];
			ctx.fillText(SIGNS[kind] || SIGNS.event, x(at), 8);
		}
		ctx.fillStyle = colour.ink2;
		ctx.fillText("forward speed", 56, high - 8);
		ctx.fillStyle = colour.ink;
		ctx.fillRect(x(at) - 1.5, 0, 3, high);
		put("clock", `${clockText(at)} of ${clockText(duration)}`);
		Object.assign($("line"), {value: at, ariaValueText: clockText(at)});
	}
}
