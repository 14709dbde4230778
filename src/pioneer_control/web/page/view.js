// The camera above the map: which place lies where on the screen. Pixels are those of CSS, y down; places are m, y up.

export class Camera {
	x = 0; y = 0; scale = 60; width = 1; height = 1; follows = false; fitted = true;

	toScreen([x, y]) {
		return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
	}

	toWorld([px, py]) {
		return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
	}

	// The place under the pixel stays there; while the camera follows a robot, that robot stays.
	zoom(factor, pixel = [this.width / 2, this.height / 2]) {
		const [x, y] = this.toWorld(pixel);
		Object.assign(this, {scale: Math.min(800, Math.max(3, this.scale * factor)), fitted: false});
		const [x2, y2] = this.toWorld(pixel);
		if (!this.follows) Object.assign(this, {x: this.x + x - x2, y: this.y + y - y2});
	}

	drag(dx, dy) {
		Object.assign(this, {x: this.x - dx / this.scale, y: this.y + dy / this.scale, follows: false, fitted: false});
	}

	fit([x1, y1, x2, y2], top = 24) {
		const bottom = 56, wide = this.width - 48, high = this.height - top - bottom;
		const scale = Math.max(1, Math.min(250, wide / Math.max(x2 - x1, 0.1), high / Math.max(y2 - y1, 0.1)));
		Object.assign(this, {x: (x1 + x2) / 2, y: (y1 + y2 + (top - bottom) / scale) / 2, scale, follows: false});
	}
}

// The longest of 1, 2 or 5 times a power of ten (m) that is not wider than so many pixels.
export function roundLength(scale, pixels) {
	const power = 10 ** Math.floor(Math.log10(pixels / scale));
	return [5, 2, 1].find(each => each * power * scale <= pixels) * power;
}

// Fingers, mouse and wheel move the camera: moved() is called then, clicked([x, y]) for a click.
export function listenView(canvas, camera, moved, clicked) {
	const fingers = new Map(), at = event => [event.offsetX, event.offsetY], far = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
	let way = 0;
	canvas.onpointerdown = event => {
		canvas.setPointerCapture(event.pointerId);
		if (!fingers.size) way = 0;
		fingers.set(event.pointerId, at(event));
	};
	canvas.onpointermove = event => {
		const id = event.pointerId, before = fingers.get(id), now = at(event), other = [...fingers].find(each => each[0] !== id)?.[1];
		if (!before) return;
		way += far(now, before);
		fingers.set(id, now);
		if (other) camera.zoom(far(now, other) / Math.max(1, far(before, other)), now.map((each, axis) => (each + other[axis]) / 2));
		if (way > 6 && !(other && camera.follows)) camera.drag((now[0] - before[0]) / fingers.size, (now[1] - before[1]) / fingers.size);
		moved();
	};
	canvas.onpointerup = canvas.onpointercancel = event => {
		fingers.delete(event.pointerId);
		if (event.type === "pointerup" && way <= 6) clicked(at(event));
	};
	canvas.addEventListener("wheel", event => {
		event.preventDefault();
		camera.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), at(event));
		moved();
	}, {passive: false});
}
