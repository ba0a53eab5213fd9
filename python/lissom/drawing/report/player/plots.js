// Curves in the plane: axes, legend, and a cursor that shows the time of the motion, or where the pointer is.

import { onPaper, sharpness } from "lissom/paper.js";
import { buttons } from "lissom/plotfiles.js";
import { DASHES, FONT, lookOf, mark } from "lissom/strokes.js";
import { decades, labels, power, shortly, ticks } from "lissom/ticks.js";

/** Room around the curves, part of their range. */
const ROOM = 0.05;
/** Left of the curves, pixels: as much for most plots, so that their times stand above each other. */
const LEFT = 64;
/** A plot has at most so many values in its line of values. */
const MOST_VALUES = 6;

/** Drawn by the processor: long dashed curves take graphics cards, and their stand-ins, up to half a minute. */
const penOf = (canvas) => canvas.getContext("2d", { willReadFrequently: true });

const make = (tag, attributes, ...inner) => {
  const element = Object.assign(document.createElement(tag), attributes);
  element.append(...inner);
  return element;
};

/** All plots of a figure, in `holder`; what draws them anew. */
export function figure(holder, told, clock) {
  const hidden = new Set();
  const plots = told.rows.map((row) => row.map((plot) => new Plot(plot, told, hidden, clock)));
  const all = plots.flat();
  const head = make("div", { className: "head" });
  if (told.legend) head.append(legend(all, hidden));
  head.append(buttons(all));
  holder.append(head);
  for (const row of plots) {
    holder.append(make("div", { className: "plots" }, ...row.map(({ element }) => element)));
  }
  const redraw = () => all.forEach((plot) => plot.draw());
  // Draw at once: the observer calls back in the next frame only, and a page that is ready must show its curves.
  redraw();
  let width = holder.clientWidth;
  new ResizeObserver(() => {
    if (holder.clientWidth === width) return;
    width = holder.clientWidth;
    redraw();
  }).observe(holder);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  return redraw;
}

function legend(plots, hidden) {
  const found = new Map();
  for (const curve of plots.flatMap(({ plot }) => plot.curves)) if (curve.name) found.set(curve.name, curve);
  const buttons = [...found.values()].map(({ name, colour, style, joined, mark }) => {
    const sample = make("i", { className: joined ? `line ${style}` : mark || "disc" });
    sample.style.setProperty("--colour", colour);
    const button = make("button", { type: "button", className: "entry" }, sample, name);
    button.setAttribute("aria-pressed", "true");
    button.addEventListener("click", () => {
      if (hidden.has(name)) hidden.delete(name);
      else hidden.add(name);
      button.setAttribute("aria-pressed", String(!hidden.has(name)));
      plots.forEach((plot) => plot.draw());
    });
    return button;
  });
  const list = make("div", { className: "legend" }, ...buttons);
  list.setAttribute("role", "group");
  list.setAttribute("aria-label", "Curves that are shown");
  return list;
}

class Plot {
  constructor(plot, { height, clock: name }, hidden, clock) {
    Object.assign(this, { plot, hidden, height });
    this.canvas = make("canvas", { className: "curves" });
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", plot.label);
    this.element = make("div", { className: "plot" }, this.canvas);
    this.element.style.flexGrow = plot.width;
    this.element.style.height = `${height}px`;
    this.picture = document.createElement("canvas");
    this.cursor = NaN;
    this.isSeen = true;
    this.clock = name ? clock : null;
    new IntersectionObserver(([entry]) => {
      this.isSeen = entry.isIntersecting;
      this.show();
    }, { rootMargin: "100px" }).observe(this.element);
    this.clock?.listen(({ time }) => {
      this.cursor = time;
      this.show();
    });
    this.follow();
  }

  /** The pointer moves the cursor: of plots over time with a button down only, and then the time of all. */
  follow() {
    const { canvas, clock } = this;
    const move = (event) => {
      if (!this.area) return;
      const at = this.area.valueOf(event.clientX - canvas.getBoundingClientRect().left);
      if (clock) clock.seek(at);
      else {
        this.cursor = at;
        this.show();
      }
    };
    canvas.addEventListener("pointerdown", (event) => {
      clock?.pause();
      canvas.setPointerCapture(event.pointerId);
      move(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!clock || event.buttons) move(event);
    });
    if (!clock) {
      canvas.addEventListener("pointerleave", () => {
        this.cursor = NaN;
        this.show();
      });
    }
  }

  get curves() {
    return this.plot.curves.filter(({ name }) => !this.hidden.has(name));
  }

  /** Draw the curves anew, in the size that there is. */
  draw() {
    const { canvas, picture, element } = this;
    const [width, height] = [element.clientWidth, this.height];
    if (!width) return;
    const ratio = sharpness();
    for (const each of [canvas, picture]) Object.assign(each, { width: width * ratio, height: height * ratio });
    canvas.style.height = `${height}px`;
    this.ratio = ratio;
    const pen = penOf(picture);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.look = lookOf(element);
    this.area = this.render(pen, width, height, this.look);
    this.copy();
  }

  /** Draw axes and curves with a pen; how values become pixels. */
  render(pen, width, height, look) {
    pen.font = FONT;
    const area = this.axes(pen, width, height, look);
    this.paint(pen, area);
    return area;
  }

  axes(pen, width, height, look) {
    const { plot } = this;
    const [x, y] = ["x", "y"].map((axis) => range(plot, axis));
    const top = plot.title ? 40 : 24;
    const bottom = height - (plot.x.title ? 44 : 26);
    const upright = marks(plot.y, y, (bottom - top) / 42);
    const left = Math.max(LEFT, 30 + Math.max(...upright.texts.map((text) => pen.measureText(text).width)));
    const right = width - 14;
    if (plot.toScale) evenOut(x, y, (right - left) / (bottom - top));
    const level = plot.toScale ? marks(plot.y, y, (bottom - top) / 42) : upright;
    const across = marks(plot.x, x, (right - left) / 80);
    const toX = (value) => left + ((value - x[0]) / (x[1] - x[0])) * (right - left);
    const toY = (value) => bottom - ((value - y[0]) / (y[1] - y[0])) * (bottom - top);
    pen.lineWidth = 1;
    pen.strokeStyle = look.line;
    pen.fillStyle = look.soft;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    level.places.forEach((place, i) => {
      line(pen, left, toY(place), right, toY(place));
      pen.fillText(level.texts[i], left - 6, toY(place));
    });
    pen.textAlign = "center";
    pen.textBaseline = "top";
    across.places.forEach((place, i) => {
      line(pen, toX(place), top, toX(place), bottom);
      pen.fillText(across.texts[i], toX(place), bottom + 6);
    });
    pen.fillText([plot.x.title, across.factor].filter(Boolean).join("  "), 0.5 * (left + right), bottom + 24);
    pen.save();
    pen.translate(9, 0.5 * (top + bottom));
    pen.rotate(-Math.PI / 2);
    pen.textBaseline = "middle";
    pen.fillText([plot.y.title, level.factor].filter(Boolean).join("  "), 0, 0);
    pen.restore();
    if (plot.title) {
      pen.fillStyle = look.ink;
      pen.textBaseline = "top";
      pen.fillText(plot.title, 0.5 * (left + right), 4);
    }
    const valueOf = (pixel) => x[0] + ((pixel - left) / (right - left)) * (x[1] - x[0]);
    return { left, right, top, bottom, toX, toY, valueOf };
  }

  paint(pen, area) {
    const { plot } = this;
    const { left, right, top, bottom, toX, toY } = area;
    pen.save();
    pen.beginPath();
    pen.rect(left, top, right - left, bottom - top);
    pen.clip();
    pen.lineJoin = "round";
    for (const curve of this.curves) {
      const [xs, ys] = [seen(plot.x, curve.x), seen(plot.y, curve.y)];
      pen.strokeStyle = pen.fillStyle = curve.colour;
      pen.lineWidth = curve.width;
      if (curve.joined) {
        pen.setLineDash(DASHES[curve.style]);
        pen.beginPath();
        let isBroken = true;
        for (let i = 0; i < xs.length; i++) {
          if (!Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) isBroken = true;
          else {
            pen[isBroken ? "moveTo" : "lineTo"](toX(xs[i]), toY(ys[i]));
            isBroken = false;
          }
        }
        pen.stroke();
        pen.setLineDash([]);
      }
      if (curve.mark) xs.forEach((value, i) => mark(pen, curve.mark, toX(value), toY(ys[i])));
    }
    pen.textAlign = "left";
    pen.textBaseline = "bottom";
    for (const { axis, at, colour, text } of plot.notes) {
      pen.strokeStyle = pen.fillStyle = colour;
      pen.lineWidth = 1.5;
      pen.setLineDash(DASHES.dot);
      const place = plot[axis].log ? Math.log10(at) : at;
      if (axis === "x") line(pen, toX(place), top, toX(place), bottom);
      else line(pen, left, toY(place), right, toY(place));
      pen.setLineDash([]);
      if (axis === "x") pen.fillText(text, toX(place) + 5, top + 16);
    }
    pen.restore();
  }

  /** Show the curves with the cursor, which moves in sight only. */
  show() {
    if (this.area && (this.isSeen || onPaper())) this.copy();
  }

  copy() {
    const { canvas, picture, area, plot, cursor, ratio, look } = this;
    const pen = penOf(canvas);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.drawImage(picture, 0, 0);
    const x = area.toX(cursor);
    if (!(x >= area.left - 1 && x <= area.right + 1)) return;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.strokeStyle = look.soft;
    pen.lineWidth = 1;
    line(pen, x, area.top, x, area.bottom);
    const values = [];
    for (const curve of this.curves.filter(({ joined }) => joined)) {
      const value = valueAt(seen(plot.x, curve.x), seen(plot.y, curve.y), cursor);
      if (!Number.isFinite(value)) continue;
      const y = area.toY(value);
      if (y >= area.top && y <= area.bottom) {
        pen.fillStyle = curve.colour;
        pen.beginPath();
        pen.arc(x, y, 3.5, 0, 2 * Math.PI);
        pen.fill();
      }
      values.push([curve, plot.y.log ? 10 ** value : value]);
    }
    this.write(pen, values.slice(0, MOST_VALUES));
  }

  /** Values at the cursor, above the plot. */
  write(pen, values) {
    const { area, plot, look, cursor } = this;
    const room = area.right - area.left;
    pen.font = FONT;
    pen.textBaseline = "alphabetic";
    pen.textAlign = "left";
    const at = plot.x.log ? 10 ** cursor : cursor;
    const first = plot.x.title ? `${plot.x.title.replace(/ \(.*/, "")} ${shortly(at)}` : "";
    const texts = values.map(([{ name }, value]) => `${name ? `${name} ` : ""}${shortly(value)}`);
    let x = area.left;
    const write = (text, colour) => {
      const width = pen.measureText(text).width;
      if (x + width > area.left + room) return;
      pen.fillStyle = colour;
      pen.fillText(text, x, area.top - 7);
      x += Math.max(width, 40) + 16;
    };
    if (first) write(first, look.soft);
    values.forEach(([{ colour }], i) => write(texts[i], colour));
  }
}

const line = (pen, x1, y1, x2, y2) => {
  pen.beginPath();
  pen.moveTo(x1, y1);
  pen.lineTo(x2, y2);
  pen.stroke();
};

const logs = new WeakMap();

/** Values as they are laid out: their logarithms on such an axis. */
function seen(axis, array) {
  if (!axis.log) return array.values;
  if (!logs.has(array)) logs.set(array, array.values.map((value) => (value > 0 ? Math.log10(value) : NaN)));
  return logs.get(array);
}

/** The range of an axis: as given, or of all curves with some room. */
function range(plot, name) {
  const axis = plot[name];
  if (axis.range) return axis.log ? axis.range.map(Math.log10) : [...axis.range];
  let [low, high] = [Infinity, -Infinity];
  for (const curve of plot.curves) {
    for (const value of seen(axis, curve[name])) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low <= high)) return [0, 1];
  const size = high - low;
  // What differs by rounding alone is no course in time.
  const least = 1e-9 * Math.max(Math.abs(low), Math.abs(high));
  if (size <= least) return low === 0 ? [-1, 1] : [low - 0.5 * Math.abs(low), high + 0.5 * Math.abs(high)];
  const room = name === "x" && !plot.toScale && plot.curves.every(({ joined, mark }) => joined && !mark) ? 0 : ROOM * size;
  return [low - room, high + room];
}

/** Make a unit as long on both axes. */
function evenOut(x, y, aspect) {
  const [wide, tall] = [x[1] - x[0], y[1] - y[0]];
  const [short, wanted] = wide < tall * aspect ? [x, tall * aspect] : [y, wide / aspect];
  const more = 0.5 * (wanted - (short[1] - short[0]));
  short[0] -= more;
  short[1] += more;
}

function marks(axis, [low, high], count) {
  if (axis.log) {
    const places = decades(low, high, count);
    return { places, texts: places.map(power), factor: "" };
  }
  const places = ticks(low, high, count);
  return { places, ...labels(places) };
}

/** Between the points of a curve whose x rises; NaN elsewhere. */
function valueAt(xs, ys, x) {
  let [low, high] = [0, xs.length - 1];
  if (high < 0 || !(xs[low] <= x && x <= xs[high])) return NaN;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] <= x) low = middle;
    else high = middle;
  }
  const size = xs[high] - xs[low];
  return size > 0 ? ys[low] + ((x - xs[low]) / size) * (ys[high] - ys[low]) : ys[low];
}
