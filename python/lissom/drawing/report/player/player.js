// A view in space with its controls: play, time, speed, views, colours, layers, files.

import { Camera } from "lissom/camera.js";
import { ofPage, parse, ways } from "lissom/colours.js";
import { compose, exportAs, kinds, sizes } from "lissom/export.js";
import { Overlay } from "lissom/overlay.js";
import { onPaper, sharpness } from "lissom/paper.js";
import { Stage } from "lissom/stage.js";
import { shortly } from "lissom/ticks.js";

/** Speeds to pick from. */
const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];
/** Real time unless the whole would take less or more, seconds. */
const SHORTEST = 1.5;
const LONGEST = 60;
/** Of what has no time of its own: seconds for all of it. */
const SLIDES = 4;
/** Steps of the slider. */
const STEPS = 1000;
/** Where pictures of a motion follow each other more slowly than this, milliseconds, they get fewer pixels, down to a part. */
const SLOW = 50;
const COARSEST = 0.6;

const HELP = "Drag to turn, shift-drag or two fingers to move, pinch to zoom; click the view to zoom with the wheel. "
  + "Keys: space plays, arrows turn, + and − zoom, comma and full stop step, 0 to 3 choose a view.";

const make = (tag, attributes, ...inner) => {
  const { label, ...rest } = attributes;
  const element = Object.assign(document.createElement(tag), rest);
  if (label) element.setAttribute("aria-label", label);
  element.append(...inner);
  return element;
};

const button = (text, action, attributes = {}) => {
  const made = make("button", { type: "button", ...attributes }, text);
  made.addEventListener("click", () => action(made));
  return made;
};

const select = (name, options, picked, action) => {
  const made = make("select", { autocomplete: "off" }, ...options.map((text) => make("option", { textContent: text })));
  made.selectedIndex = picked;
  made.addEventListener("change", () => action(made.selectedIndex));
  return make("label", {}, make("span", { textContent: name }), made);
};

export class Player {
  /** @param scene what `scene.py` tells, unpacked. */
  constructor(holder, scene, clock, title) {
    Object.assign(this, { holder, scene, clock, title });
    this.camera = new Camera(scene);
    this.canvas = make("canvas", { tabIndex: 0, label: `${title}. ${scene.words}` });
    this.canvas.setAttribute("role", "application");
    this.canvas.setAttribute("aria-roledescription", "view in space");
    this.over = make("canvas", { className: "over" });
    this.over.setAttribute("aria-hidden", "true");
    this.view = make("div", { className: "view" }, this.canvas, this.over);
    holder.append(this.view);
    this.stage = new Stage(this.canvas, scene, this.camera);
    this.overlay = new Overlay(this.over);
    this.ways = ways(scene.things);
    this.ratio = sharpness();
    /** How canvases are laid out: pixels of the page, and pixels of canvases for each. */
    this.laid = { width: 0, height: 0, ratio: this.ratio };
    /** Size of files, and whether pictures have no background. */
    this.size = sizes[0];
    this.isTransparent = false;
    this.isSeen = true;
    this.intervals = [];
    this.setClock();
    this.addControls();
    this.listen();
  }

  get canvases() {
    return [this.canvas, this.over];
  }

  setClock() {
    const { clock, scene } = this;
    const times = scene.times.values;
    const whole = times.at(-1) - times[0];
    if (scene.isTime) {
      const fits = (speed) => whole / speed >= SHORTEST && whole / speed <= LONGEST;
      clock.speed = fits(1) || !whole ? 1 : SPEEDS.findLast((speed) => whole / speed >= SHORTEST) ?? SPEEDS[0];
      if (whole > LONGEST) clock.speed = SPEEDS.find((speed) => whole / speed <= LONGEST) ?? SPEEDS.at(-1);
    } else {
      clock.speed = whole / SLIDES || 1;
      clock.loops = false;
    }
    this.unit = scene.isTime ? 1 : clock.speed;
    clock.cover(times[0], times.at(-1), times[scene.opensAt]);
  }

  addControls() {
    const { clock, camera, scene, stage, holder } = this;
    const isStill = clock.end <= clock.start;
    this.playing = button("", () => clock.toggle(), { className: "play" });
    this.slider = make("input", { type: "range", min: 0, max: STEPS, step: "any", autocomplete: "off" });
    this.slider.setAttribute("aria-label", scene.isTime ? "time" : "place in the series");
    this.slider.addEventListener("input", () => {
      // The slider follows the clock, also when that stops.
      const part = this.slider.value / STEPS;
      clock.pause();
      clock.seek(clock.start + part * (clock.end - clock.start));
    });
    this.now = make("output", { className: "now" });
    const speeds = SPEEDS.map((speed) => `${speed} ×`);
    const speed = select("Speed", speeds, Math.max(SPEEDS.indexOf(clock.speed / this.unit), 0), (i) => {
      clock.speed = SPEEDS[i] * this.unit;
    });
    const loop = button("Loop", (self) => {
      clock.loops = !clock.loops;
      self.setAttribute("aria-pressed", String(clock.loops));
    });
    loop.setAttribute("aria-pressed", String(clock.loops));
    const time = make("div", { className: "controls" }, this.playing, this.slider, this.now, speed, loop);
    time.hidden = isStill;
    const views = ["fit", "front", "side", "top"].map((name) =>
      button(name[0].toUpperCase() + name.slice(1), () => camera.show(name), { label: `view: ${name}` }));
    const tools = make("div", { className: "controls tools" }, group("View", views));
    if (stage.tubes.length) {
      tools.append(select("Colour", this.ways.map(({ name }) => name), 0, (i) => {
        stage.way = this.ways[i];
        this.invalidate();
      }));
    }
    this.status = make("span", { className: "status" });
    this.status.setAttribute("role", "status");
    const saves = kinds(isStill).map((kind) => button(kind.name, () => this.save(kind), { label: `save as ${kind.name}` }));
    const size = select("Size of files", sizes.map(({ name }) => name), 0, (i) => {
      this.size = sizes[i];
    });
    this.stop = button("Stop", () => {
      this.isStopped = true;
    }, { hidden: true });
    tools.append(group("Save", saves), size, this.status, this.stop);
    holder.append(time, tools, this.legend());
    const help = make("summary", { textContent: "How to move the view" });
    holder.append(make("details", { className: "help" }, help, make("p", { textContent: HELP })));
  }

  legend() {
    const entries = this.scene.layers.map(({ layer, name, colour }) => {
      const sample = make("i", { className: "disc" });
      sample.style.setProperty("--colour", colour);
      const entry = button("", (self) => {
        const { hidden } = this.stage;
        if (hidden.has(layer)) hidden.delete(layer);
        else hidden.add(layer);
        self.setAttribute("aria-pressed", String(!hidden.has(layer)));
        this.invalidate();
      }, { className: "entry" });
      const of = this.scene.surroundings.find((words) => words.startsWith(layer));
      entry.append(sample, of ?? name);
      entry.setAttribute("aria-pressed", "true");
      return entry;
    });
    const list = make("div", { className: "legend", label: "Layers that are shown" }, ...entries);
    list.setAttribute("role", "group");
    return list;
  }

  async save(kind) {
    if (this.isSaving) return;
    Object.assign(this, { isSaving: true, isStopped: false });
    this.stop.hidden = !kind.moves;
    this.clock.pause();
    try {
      this.lay(this.size.of({ width: this.view.clientWidth, height: this.view.clientHeight, ratio: sharpness() }));
      this.stage.check();
      await exportAs(kind, this, (part) => {
        this.status.textContent = `${kind.name}: ${Math.round(100 * Math.min(part, 1))} %`;
        if (this.isStopped) throw new Error("it was stopped");
      });
      this.status.textContent = `${kind.name} saved`;
    } catch (error) {
      this.status.textContent = `${kind.name} not made: ${error.message}`;
    }
    this.stop.hidden = true;
    this.isSaving = false;
    this.resize();
  }

  listen() {
    const { canvas, camera, clock } = this;
    camera.attach(canvas);
    camera.listeners.add(() => this.invalidate());
    clock.listen(() => this.tick());
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const step = (clock.end - clock.start) / 200;
      if (event.key === " ") clock.toggle();
      else if (event.key === "," || event.key === ".") {
        clock.pause();
        clock.seek(clock.time + (event.key === "." ? step : -step));
      } else if (!camera.key(event)) return;
      event.preventDefault();
    });
    new ResizeObserver(() => this.resize()).observe(this.view);
    new IntersectionObserver(([entry]) => {
      this.isSeen = entry.isIntersecting;
      if (this.isSeen) this.invalidate();
    }).observe(this.view);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.look = null;
      this.invalidate();
    });
  }

  tick() {
    const { clock } = this;
    const label = this.labelOf(clock.time);
    this.slider.value = (STEPS * (clock.time - clock.start)) / (clock.end - clock.start || 1);
    this.slider.setAttribute("aria-valuetext", label);
    this.now.textContent = label;
    const text = clock.plays ? "Pause" : "Play";
    if (this.playing.textContent !== text) this.playing.textContent = text;
    this.playing.classList.toggle("plays", clock.plays);
    this.invalidate();
  }

  labelOf(time) {
    const { clock, scene, stage } = this;
    const labels = scene.labels?.values;
    const whole = labels ? Math.max(...labels) - Math.min(...labels) : clock.end - clock.start;
    const places = Math.min(Math.max(0, Math.ceil(2.3 - Math.log10(whole || 1))), 9);
    let value = time;
    if (labels) {
      const [i, part] = stage.find(time);
      value = labels[i] + (part && part * (labels[i + 1] - labels[i]));
    }
    const number = whole > 0 ? value.toFixed(places).replace("-", "−") : shortly(value);
    return `${scene.label[0]}${number}${scene.label[1]}`;
  }

  /** Fill the view; files in the making keep their size. */
  resize() {
    if (!this.isSaving) this.lay({ width: this.view.clientWidth, height: this.view.clientHeight, ratio: this.ratio });
  }

  lay({ width, height, ratio }) {
    if (!width || !height) return;
    this.laid = { width, height, ratio };
    for (const canvas of this.canvases) {
      Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    }
    this.camera.resize(width, height);
    this.draw();
  }

  /** The page has another width and colours: paper shows a still, because what a graphics card has drawn is not printed. */
  relaid() {
    this.still?.remove();
    this.still = null;
    this.look = null;
    this.ratio = sharpness();
    this.resize();
    if (!onPaper() || !this.view.clientWidth || this.isSaving) return;
    this.still = make("canvas", { className: "still" });
    compose(this, this.still);
    this.view.append(this.still);
  }

  /** Draw soon, once. */
  invalidate() {
    if (this.isWaiting || this.isSaving) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      if (this.isSeen && !this.isSaving) this.draw();
    });
  }

  draw(time = this.clock.time) {
    if (!this.canvas.width) return;
    this.look ??= this.lookOfPage();
    this.look.ratio = this.laid.ratio;
    this.look.opacity = this.isTransparent ? 0 : 1;
    this.stage.draw(time, this.look);
    this.overlay.draw(this.stage, this.look, this.clock.end > this.clock.start ? this.labelOf(time) : "");
    this.spare();
  }

  lookOfPage() {
    const of = (name) => ofPage(this.holder, name);
    const dark = matchMedia("(prefers-color-scheme: dark)").matches && !onPaper();
    return { ground: parse(of("--view")), soft: parse(of("--soft")), inkText: of("--ink"), softText: of("--soft"), isDark: dark };
  }

  /** Fewer pixels where pictures follow each other slowly. */
  spare() {
    const [now, before] = [performance.now(), this.before];
    this.before = this.clock.plays && !this.isSaving ? now : null;
    if (!this.before || !before) return;
    this.intervals.push(now - before);
    if (this.intervals.length < 9) return;
    const median = this.intervals.sort((a, b) => a - b)[4];
    this.intervals = [];
    if (median > SLOW && this.ratio > COARSEST) {
      this.ratio = Math.max(COARSEST, 0.75 * this.ratio);
      this.resize();
    }
  }
}

function group(name, buttons) {
  const made = make("div", { className: "group", label: name }, make("span", { textContent: name }), ...buttons);
  made.setAttribute("role", "group");
  return made;
}
