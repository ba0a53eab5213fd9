// From where the view is seen: a camera that orbits a point, moved by pointer, touch and keys.

import { add, cross, dot, looking, multiply, orthographic, perspective, scale, subtract, unit } from "lissom/vectors.js";

/** Angle of view from below to above, radians; below the smallest one, lines of sight are parallel. */
const ANGLE = 0.56;
const SMALLEST = 0.01;
/** Radians a pixel, factor a click of the wheel, radians and factor a key. */
const TURN = 0.008;
const WHEEL = 0.0012;
const KEY_TURN = 0.12;
const KEY_ZOOM = 1.15;
/** So near to the poles the camera comes, radians; exactly above them up has no direction. */
const POLE = 1e-3;
/** Of a flight to another view, milliseconds. */
const FLIGHT = 350;
/** Room around the box. */
const ROOM = 0.94;
/** What is written along the upper edge, pixels. */
const WRITING = 44;

export class Camera {
  constructor({ low, high, eye, ground }) {
    this.low = low;
    this.high = high;
    this.up = [0, 0, 0];
    this.up[ground.axis] = ground.sign;
    // Two axes across it: seen along the second one, the first goes to the right.
    this.across = [0, 0, 0];
    this.across[ground.axis === 0 ? 1 : 0] = 1;
    this.along = cross(this.up, this.across);
    this.home = this.angles(eye);
    this.aspect = 1;
    /** Part of the view's height that the writing takes. */
    this.written = 0;
    this.isHome = true;
    this.angle = ANGLE;
    this.listeners = new Set();
    Object.assign(this, this.fitting(this.home));
  }

  angles(direction) {
    const d = unit(direction);
    const height = Math.asin(Math.min(Math.max(dot(d, this.up), -1), 1));
    const isPole = Math.abs(height) > Math.PI / 2 - POLE;
    const around = isPole ? -Math.PI / 2 : Math.atan2(dot(d, this.along), dot(d, this.across));
    return { around, height: Math.min(Math.max(height, POLE - Math.PI / 2), Math.PI / 2 - POLE) };
  }

  frame({ around, height } = this) {
    const flat = add(scale(this.across, Math.cos(around)), scale(this.along, Math.sin(around)));
    const back = add(scale(flat, Math.cos(height)), scale(this.up, Math.sin(height)));
    const right = unit(cross(this.up, back));
    return { right, up: cross(back, right), back };
  }

  /** Whether lengths across the view are to scale, near and far. */
  get isParallel() {
    return this.angle < SMALLEST;
  }

  /** Half the height of what is seen at the point that is looked at, metres: the same for all angles. */
  get reach() {
    return this.distance * Math.tan(ANGLE / 2);
  }

  /** Where all of the box is seen from that direction, below the writing. */
  fitting(angles, isParallel = false) {
    const { right, up, back } = this.frame(angles);
    const middle = scale(add(this.low, this.high), 0.5);
    const tall = Math.tan(ANGLE / 2) / ROOM;
    const wide = tall * this.aspect;
    const strip = 2 * Math.tan(ANGLE / 2) * this.written;
    const corners = [...Array(8).keys()].map((i) => {
      const corner = subtract([0, 1, 2].map((axis) => ((i >> axis) & 1 ? this.high : this.low)[axis]), middle);
      return [dot(corner, right), dot(corner, up), isParallel ? 0 : dot(corner, back)];
    });
    // The point that is looked at is shifted until there is as much room on all sides.
    let [x, y, distance] = [0, 0, 0];
    for (let round = 0; round < 3; round++) {
      const sides = { right: 0, left: 0, above: 0, below: 0 };
      distance = 0;
      for (const corner of corners) {
        const [a, b, c] = [corner[0] - x, corner[1] - y, corner[2]];
        distance = Math.max(distance, c + Math.abs(a) / wide, c + b / (tall - strip), c - b / tall);
      }
      for (const corner of corners) {
        const depth = distance - corner[2];
        const [a, b] = [(corner[0] - x) / depth, (corner[1] - y) / depth];
        sides.right = Math.max(sides.right, a);
        sides.left = Math.max(sides.left, -a);
        sides.above = Math.max(sides.above, b);
        sides.below = Math.max(sides.below, -b);
      }
      x += 0.5 * (sides.right - sides.left) * distance;
      y += 0.5 * (sides.above - sides.below + strip) * distance;
    }
    return { ...angles, target: add(middle, add(scale(right, x), scale(up, y))), distance };
  }

  resize(width, height) {
    this.aspect = width / height;
    this.written = Math.min(WRITING / height, 0.25);
    if (this.isHome) Object.assign(this, this.fitting(this.home));
  }

  changed() {
    this.isHome = false;
    for (const listener of this.listeners) listener();
  }

  turn(around, height) {
    this.around += around;
    this.height = Math.min(Math.max(this.height + height, POLE - Math.PI / 2), Math.PI / 2 - POLE);
    this.changed();
  }

  pan(x, y) {
    const { right, up } = this.frame();
    this.target = add(this.target, add(scale(right, x * this.distance), scale(up, y * this.distance)));
    this.changed();
  }

  zoom(factor) {
    const size = Math.hypot(...subtract(this.high, this.low));
    this.distance = Math.min(Math.max(this.distance * factor, 0.02 * size), 20 * size);
    this.changed();
  }

  /** Fly to a view by its name: home in perspective, the others along an axis with parallel lines of sight. */
  show(name) {
    const { across, along, up } = this;
    const directions = { front: scale(along, -1), side: across, top: up };
    const isParallel = name in directions;
    const goal = { ...this.fitting(isParallel ? this.angles(directions[name]) : this.home, isParallel), angle: isParallel ? 0 : ANGLE };
    if (name === "top") goal.around = -Math.PI / 2;
    const start = { ...this };
    const turn = goal.around - start.around;
    const shortest = turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI));
    const isQuick = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const began = performance.now();
    const fly = () => {
      const part = isQuick ? 1 : Math.min((performance.now() - began) / FLIGHT, 1);
      const s = part * part * (3 - 2 * part);
      this.around = start.around + s * shortest;
      this.height = start.height + s * (goal.height - start.height);
      this.distance = start.distance * (goal.distance / start.distance) ** s;
      this.angle = start.angle + s * (goal.angle - start.angle);
      this.target = add(start.target, scale(subtract(goal.target, start.target), s));
      this.changed();
      if (part < 1) requestAnimationFrame(fly);
      else this.isHome = !isParallel;
    };
    fly();
  }

  /** The matrix from the world to the screen, and where the eye is. */
  look() {
    const { aspect, isParallel, reach } = this;
    const axes = this.frame();
    const size = Math.hypot(...subtract(this.high, this.low));
    const distance = reach / Math.tan(Math.max(this.angle, SMALLEST) / 2);
    const eye = add(this.target, scale(axes.back, distance));
    const near = Math.max(0.01 * distance, distance - 4 * size);
    const far = distance + 30 * size;
    const view = looking(eye, axes.right, axes.up, axes.back);
    const seen = isParallel ? orthographic(2 * reach * aspect, 2 * reach, near, far) : perspective(this.angle, aspect, near, far);
    return { ...axes, eye, matrix: multiply(seen, view) };
  }

  /** Let a canvas move the camera. */
  attach(canvas) {
    const pointers = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
    }
    canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const now = [event.clientX, event.clientY];
      const [x, y] = [now[0] - before[0], now[1] - before[1]];
      const height = canvas.clientHeight || 1;
      if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
        const apart = (point) => Math.hypot(point[0] - other[0], point[1] - other[1]) || 1;
        this.zoom(apart(before) / apart(now));
        this.pan((-0.25 * x) / height, (0.25 * y) / height);
      } else if (event.shiftKey || event.buttons === 2 || event.buttons === 4) {
        this.pan((-ANGLE * x) / height, (ANGLE * y) / height);
      } else {
        this.turn(-TURN * x, TURN * y);
      }
      pointers.set(event.pointerId, now);
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("dblclick", () => this.show("fit"));
    // The wheel scrolls the page until the view was clicked.
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return;
      event.preventDefault();
      this.zoom(Math.exp(WHEEL * event.deltaY));
    }, { passive: false });
  }

  /** What a key does; false if nothing. */
  key(event) {
    const [x, y] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] ?? [0, 0];
    if (x || y) {
      if (event.shiftKey) this.pan(0.03 * x, 0.03 * y);
      else this.turn(KEY_TURN * x, KEY_TURN * y);
    } else if (event.key === "+" || event.key === "=") this.zoom(1 / KEY_ZOOM);
    else if (event.key === "-") this.zoom(KEY_ZOOM);
    else if (event.key in { 0: 1, 1: 1, 2: 1, 3: 1 }) this.show(["fit", "front", "side", "top"][event.key]);
    else return false;
    return true;
  }
}
