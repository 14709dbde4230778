// The time line of a recording: speed and battery over time, marks, and where we are; to play, to seek, to jump.

const RATES = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20];
const KINDS = {fault: ["▲", "bad"], decision: ["╵", "ink2"], event: ["◆", "goal"]};
const CURVES = [["linear", "Forward", "program"], ["angular", "Turn left", "cone"], ["battery", "Battery", "person"]];
const LEFT = 74, RIGHT = 12, TOP = 18;      // pixels around the curves

export function clockText(at) {
  const tenths = Math.round(10 * at);
  return `${Math.floor(tenths / 600)}:${String(Math.floor(tenths / 10) % 60).padStart(2, "0")}.${tenths % 10}`;
}

export class TimeLine {
  // chosen() gives the chosen robot, sought() is called when the time was changed.
  constructor(recording, colours, chosen, sought) {
    const get = id => document.getElementById(id), canvas = get("line");
    Object.assign(this, {recording, colours, chosen, sought, get, canvas, playing: false, rate: 1, curves: null});
    get("time").hidden = false;
    for (const rate of RATES) get("rate").append(new Option(rate + "×", rate, rate === 1, rate === 1));
    get("rate").onchange = event => this.rate = Number(event.target.value);
    get("play").onclick = () => this.toggle();
    get("mark-previous").onclick = () => this.jump(-1);
    get("mark-next").onclick = () => this.jump(1);
    canvas.onpointerdown = event => {
      canvas.setPointerCapture(event.pointerId);
      this.point(event);
    };
    canvas.onpointermove = event => event.buttons && this.point(event);
    canvas.onkeydown = event => this.key(event);
    new ResizeObserver(() => this.dress()).observe(canvas);
  }

  toggle() {
    if (!this.playing && this.recording.at >= this.recording.duration) this.seek(0);
    this.playing = !this.playing;
    this.get("play").textContent = this.playing ? "⏸" : "▶";
    this.get("play").setAttribute("aria-label", (this.playing ? "Pause" : "Play") + " (space bar)");
  }

  seek(at) {
    this.recording.seek(at);
    this.sought();
  }

  point(event) {
    const wide = this.canvas.clientWidth - LEFT - RIGHT;
    this.seek((event.offsetX - LEFT) / wide * this.recording.duration);
  }

  key(event) {
    const {at, duration} = this.recording, step = event.shiftKey ? 10 : 1;
    const to = {ArrowLeft: at - step, ArrowRight: at + step, ArrowDown: at - step, ArrowUp: at + step, PageDown: at - 30,
      PageUp: at + 30, Home: 0, End: duration}[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.seek(to);
  }

  jump(way) {
    const mark = this.recording.mark(this.chosen().number, way);
    if (mark) this.go(mark);
  }

  go(mark) {
    this.seek(mark.at);
    this.get("mark-text").textContent = mark.text;
  }

  // Called for each picture, with the seconds since the last one. Tells whether anything moved.
  advance(seconds) {
    if (!this.playing) return false;
    this.seek(this.recording.at + this.rate * seconds);
    if (this.recording.at >= this.recording.duration) this.toggle();
    return true;
  }

  // All but the mark of now is painted once.
  dress() {
    this.curves = null;
  }

  draw() {
    const {canvas, recording, colours} = this, wide = canvas.clientWidth, high = canvas.clientHeight;
    const ratio = Math.min(3, window.devicePixelRatio || 1), number = this.chosen() ? this.chosen().number : null;
    if (!this.curves || this.curves.of !== number || this.curves.known !== recording.columns.size) {
      this.curves = document.createElement("canvas");
      Object.assign(this.curves, {of: number, known: recording.columns.size});
      this.paint(this.curves, wide, high, ratio, number);
      canvas.width = this.curves.width;
      canvas.height = this.curves.height;
    }
    const ctx = canvas.getContext("2d"), x = ratio * this.across(recording.at, wide);
    ctx.clearRect(0, 0, canvas.width, canvas.height);
    ctx.drawImage(this.curves, 0, 0);
    ctx.fillStyle = colours().ink;
    ctx.fillRect(x - ratio, 0, 2 * ratio, canvas.height);
    ctx.beginPath();
    ctx.arc(x, 6 * ratio, 6 * ratio, 0, 7);
    ctx.fill();
    const text = `${clockText(recording.at)} of ${clockText(recording.duration)}`;
    if (this.get("clock").textContent === text) return;
    this.get("clock").textContent = text;
    canvas.setAttribute("aria-valuemax", recording.duration);
    canvas.setAttribute("aria-valuenow", recording.at.toFixed(1));
    canvas.setAttribute("aria-valuetext", text);
  }

  across(at, wide) {
    return LEFT + at / Math.max(0.001, this.recording.duration) * (wide - LEFT - RIGHT);
  }

  paint(canvas, wide, high, ratio, number) {
    const ctx = canvas.getContext("2d"), colour = this.colours(), strip = (high - TOP - 2) / CURVES.length;
    canvas.width = Math.round(wide * ratio);
    canvas.height = Math.round(high * ratio);
    ctx.scale(ratio, ratio);
    ctx.font = '11px system-ui, "DejaVu Sans", sans-serif';
    ctx.textBaseline = "middle";
    CURVES.forEach(([name, title, ink], i) => {
      const top = TOP + i * strip, curve = this.recording.curve(number, name, wide), values = curve.map(each => each[1]);
      const signed = name !== "battery", most = signed ? Math.max(0.1, ...values.map(Math.abs)) : Math.max(...values) + 0.2;
      const least = signed ? -most : Math.min(...values) - 0.2, tall = strip - 6;
      const y = value => top + 3 + (most - value) / (most - least) * tall;
      ctx.fillStyle = colour.ink2;
      ctx.fillText(title, 8, top + strip / 2);
      ctx.strokeStyle = colour.grid;
      ctx.lineWidth = 1;
      ctx.strokeRect(LEFT + 0.5, Math.round(top) + 0.5, wide - LEFT - RIGHT, strip - 1);
      ctx.strokeStyle = colour[ink];
      ctx.lineWidth = 1.75;
      ctx.beginPath();
      for (const [at, value] of curve) ctx.lineTo(this.across(at, wide), y(value));
      if (!signed && curve.length) ctx.lineTo(this.across(this.recording.duration, wide), y(curve[curve.length - 1][1]));
      ctx.stroke();
    });
    ctx.textAlign = "center";
    for (const mark of this.recording.marks) {
      if (mark.robot !== number && mark.robot !== null && mark.robot !== undefined) continue;
      const [sign, ink] = KINDS[mark.kind] || KINDS.event;
      ctx.fillStyle = colour[ink];
      ctx.fillText(sign, this.across(mark.at, wide), TOP - 7);
    }
  }

  // Fills the list of marks of a robot; a click goes there.
  list(number, most = 500) {
    const items = this.recording.marks.filter(mark => mark.robot === number || mark.robot == null).slice(0, most).map(mark => {
      const button = document.createElement("button"), item = document.createElement("li");
      button.type = "button";
      button.textContent = `${clockText(mark.at)} ${(KINDS[mark.kind] || KINDS.event)[0]} ${mark.text}`;
      button.onclick = () => this.go(mark);
      item.append(button);
      return item;
    });
    this.get("marks").hidden = items.length === 0;
    this.get("mark-list").replaceChildren(...items);
  }
}
