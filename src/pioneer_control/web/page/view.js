// The camera above the map: which place lies where on the screen. Pixels are those of CSS, y down; places are m, y up.

export class Camera {
	constructor() {
		Object.assign(this, {x: 0, y: 0, scale: 60, width: 1, height: 1, follows: false, changes: 0});
	}

	set(values) {
		if (Object.keys(values).every(name => this[name] === values[name])) return;
		Object.assign(this, values);
		this.changes++;
	}

	toScreen([x, y]) {
		return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
	}

	toWorld([px, py]) {
		return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
	}

	// The place under the pixel stays there; while the camera follows a robot, that robot stays.
	zoom(factor, pixel = [this.width / 2, this.height / 2]) {
		const [x, y] = this.toWorld(pixel);
		this.set({scale: Math.min(800, Math.max(3, this.scale * factor))});
		const [x2, y2] = this.toWorld(pixel);
		if (!this.follows) this.set({x: this.x + x - x2, y: this.y + y - y2});
	}

	drag(dx, dy) {
		this.set({x: this.x - dx / this.scale, y: this.y + dy / this.scale});
	}

	// Show all of x1, y1, x2, y2 between margins: so many pixels are taken at the right and at the top.
	fit([x1, y1, x2, y2], right = 0, top = 0) {
		const margin = 16, bottom = 40, wide = this.width - right - 2 * margin, high = this.height - top - bottom - margin;
		const scale = Math.min(250, wide / Math.max(x2 - x1, 0.1), high / Math.max(y2 - y1, 0.1));
		this.set({x: (x1 + x2 + right / scale) / 2, y: (y1 + y2 + (top + margin - bottom) / scale) / 2, scale});
	}
}

// The longest of 1, 2 or 5 times a power of ten (m) that is not wider than so many pixels.
export function roundLength(scale, pixels) {
	const power = 10 ** Math.floor(Math.log10(pixels / scale));
	return [5, 2, 1].find(each => each * power * scale <= pixels) * power;
}
