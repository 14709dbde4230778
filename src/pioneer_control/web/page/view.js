// The camera above the map: which place lies where on the screen. Pixels are those of CSS, y down; places are m, y up.

const NEAREST = 800, FARTHEST = 3;    // pixels for a metre

export class Camera {
  constructor() {
    Object.assign(this, {x: 0, y: 0, scale: 60, width: 1, height: 1, follows: false, changes: 0});
  }

  resize(width, height) {
    Object.assign(this, {width, height});
    this.changes++;
  }

  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toWorld(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  centre(x, y) {
    if (x === this.x && y === this.y) return;
    Object.assign(this, {x, y});
    this.changes++;
  }

  // The place under the pixel stays there; while the camera follows a robot, that robot stays.
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toWorld(px, py);
    this.scale = Math.min(NEAREST, Math.max(FARTHEST, this.scale * factor));
    const [x2, y2] = this.toWorld(px, py);
    if (!this.follows) this.centre(this.x + x - x2, this.y + y - y2);
    this.changes++;
  }

  drag(dx, dy) {
    this.follows = false;
    this.centre(this.x - dx / this.scale, this.y + dy / this.scale);
  }

  // Show all of x1, y1, x2, y2, with a margin in which scale bar and buttons have room.
  fit([x1, y1, x2, y2]) {
    const margin = Math.min(44, this.width / 12, this.height / 12);
    this.follows = false;
    this.scale = Math.min((this.width - 2 * margin) / Math.max(x2 - x1, 0.1),
        (this.height - 2 * margin) / Math.max(y2 - y1, 0.1), 250);
    this.x = (x1 + x2) / 2;
    this.y = (y1 + y2) / 2;
    this.changes++;
  }
}

// A length of 1, 2 or 5 times a power of ten that is about so many pixels wide.
export function roundLength(scale, pixels) {
  const power = 10 ** Math.floor(Math.log10(pixels / scale));
  return [5, 2, 1].find(each => each * power * scale <= pixels) * power;
}
