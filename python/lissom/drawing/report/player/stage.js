// Draws the view: things, their shadow, the ground.

import { parse, sample } from "lissom/colours.js";
import { Marks } from "lissom/marks.js";
import { Copies, square } from "lissom/meshes.js";
import { program } from "lissom/shaders.js";
import { Strand, Tube, between } from "lissom/tubes.js";
import { Visual } from "lissom/visuals.js";
import { add, cross, dot, looking, multiply, orthographic, scale, subtract, unit } from "lissom/vectors.js";

/** Pixels of the shadow's picture. */
const SHADOW = 512;
/** The layer of what stands around the model. */
const AROUND = "obstacles";
/** The pose of skins whose vertices are given in the world. */
const HERE = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
/** Cells of the grid across the box, about. */
const CELLS = 8;

export class Stage {
  constructor(canvas, scene, camera) {
    const gl = canvas.getContext("webgl2", { antialias: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    Object.assign(this, { canvas, scene, camera, gl });
    this.hidden = new Set();
    this.way = { name: "position along the rod" };
    this.tubes = scene.things.filter(({ kind }) => kind === "tube").map((thing) => new Tube(gl, thing));
    this.strands = scene.things.filter(({ kind }) => kind === "strand").map((thing) => new Strand(gl, thing));
    this.visuals = scene.things.filter(({ kind }) => kind === "mesh").map((thing) => new Visual(gl, thing));
    this.marks = new Marks(gl, scene.things);
    this.programs = {};
    for (const name of ["skin", "frustum", "figure", "skinShadow", "frustumShadow", "figureShadow", "line", "ground"]) {
      this.programs[name] = program(gl, name);
    }
    this.square = new Copies(gl, square(), []);
    this.square.copies = 1;
    this.layOutGround();
    this.shadow = this.makeShadow();
  }

  layOutGround() {
    const { low, high, ground } = this.scene;
    const { up, across, along } = this.camera;
    const middle = scale(add(low, high), 0.5);
    middle[ground.axis] = ground.place;
    const box = subtract(high, low);
    const spans = [across, along].map((axis) => Math.abs(dot(box, axis)));
    const rough = Math.max(...spans) / CELLS;
    const power = 10 ** Math.floor(Math.log10(rough));
    const cell = [1, 2, 5, 10].find((step) => step * power >= rough) * power;
    const size = 0.5 * Math.hypot(...spans);
    Object.assign(this, { cell });
    this.ground = {
      middle, across, along, up, cell, size: 2.6 * size,
      // Cells are counted from the origin of the world.
      origin: [dot(middle, across), dot(middle, along)],
      reach: spans.map((span) => 0.62 * span + 0.06 * size),
      low: dot(middle, up),
      tall: Math.max(box[ground.axis], 0.3 * size),
    };
  }

  /** Graphics cards draw up to some size only. */
  check() {
    const { gl, canvas } = this;
    if (gl.drawingBufferWidth === canvas.width && gl.drawingBufferHeight === canvas.height) return;
    throw new Error(`${canvas.width} x ${canvas.height} pixels are more than this graphics card draws`);
  }

  makeShadow() {
    const { gl } = this;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 6, gl.RGBA8, SHADOW, SHADOW);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { texture, frame };
  }

  /** The shape before a time, and how far it is to the next one. */
  find(time) {
    const times = this.scene.times.values;
    let [low, high] = [0, times.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle;
    }
    if (low === high) return [0, 0];
    return [low, Math.min(Math.max((time - times[low]) / (times[high] - times[low] || 1), 0), 1)];
  }

  paintOf({ thing }, at, part) {
    const { way, scene } = this;
    const { stations, segment, quantities } = thing;
    if (way.segments) return (k) => sample(scene.scale, segment[k] / (way.segments - 1));
    const quantity = quantities[way.name];
    if (quantity) {
      const value = between(quantity, at, part);
      return (k) => sample(scene.scale, (value(k) - way.low) / (way.high - way.low));
    }
    const whole = stations.values.at(-1) || 1;
    return (k) => sample(scene.scale, stations.values[k] / whole);
  }

  /** Draw the shape of a time. @param look colours of the page. */
  draw(time, look) {
    const [at, part] = this.find(time);
    const isShown = ({ thing }) => !this.hidden.has(thing.layer);
    const colours = new Map(this.scene.layers.filter(({ layer }) => !this.hidden.has(layer))
      .map(({ layer, colour }) => [layer, parse(colour)]));
    const [tubes, strands] = [this.tubes.filter(isShown), this.strands.filter(isShown)];
    const visuals = this.visuals.filter(isShown);
    for (const tube of tubes) tube.update(at, part, this.paintOf(tube, at, part));
    for (const strand of strands) strand.update(at, part, colours.get(strand.thing.layer));
    for (const visual of visuals) visual.update(at, part, colours.get(visual.thing.layer));
    this.marks.update(at, part, colours);
    // What is seen through is drawn last: what stands around, then chambers, then what is around these.
    const skins = [...strands, ...tubes, ...visuals];
    const solid = skins.filter(({ opacity }) => opacity >= 1);
    const clear = skins.filter(({ opacity, thing }) => opacity < 1 && thing.layer !== AROUND);
    const around = skins.filter(({ opacity, thing }) => opacity < 1 && thing.layer === AROUND);
    const { gl } = this;
    gl.disable(gl.CULL_FACE);
    if (colours.has("floor")) this.drawShadow(skins);
    const uniforms = this.begin(look);
    this.drawSolid(solid, uniforms);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    if (colours.has("floor")) this.drawGround(look);
    this.drawAround(around, solid, uniforms);
    for (const each of clear) this.drawClear(() => this.drawSkins([each], uniforms));
    this.drawLines(colours, look);
  }

  drawShadow(skins) {
    const { gl, ground, programs, marks } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadow.frame);
    gl.viewport(0, 0, SHADOW, SHADOW);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.MAX);
    const far = 100 * ground.size;
    const view = looking(ground.middle, ground.across, ground.along, cross(ground.across, ground.along));
    const matrix = multiply(orthographic(2 * ground.reach[0], 2 * ground.reach[1], -far, far), view);
    const uniforms = { matrix, up: ground.up, low: ground.low, tall: ground.tall };
    for (const { skin, thing, opacity, pose = HERE } of skins) {
      // Rods around tendons keep their shadow.
      programs.skinShadow({ ...uniforms, pose, opacity: thing.layer === AROUND ? opacity : 1 });
      skin.draw();
    }
    programs.frustumShadow(uniforms);
    marks.frustums.draw();
    programs.figureShadow(uniforms);
    for (const copies of [marks.spheres, marks.boxes, ...marks.clear]) copies.draw();
    gl.blendEquation(gl.FUNC_ADD);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.bindTexture(gl.TEXTURE_2D, this.shadow.texture);
    gl.generateMipmap(gl.TEXTURE_2D);
  }

  /** An empty picture; what programs of things have in common. */
  begin(look) {
    const { gl, camera, ground } = this;
    const { matrix, eye, right, up, back } = camera.look();
    this.matrix = matrix;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...scale(look.ground, look.opacity), look.opacity);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.disable(gl.BLEND);
    const light = unit(add(add(scale(right, -0.45), scale(up, 0.75)), scale(back, 0.7)));
    return { matrix, eye, light, up: ground.up, isDark: look.isDark ? 1 : 0 };
  }

  drawSolid(skins, uniforms) {
    const { programs, marks } = this;
    programs.frustum(uniforms);
    marks.frustums.draw();
    programs.figure(uniforms);
    marks.spheres.draw();
    marks.boxes.draw();
    this.drawSkins(skins, uniforms);
  }

  drawSkins(skins, uniforms) {
    for (const { skin, opacity, pose = HERE } of skins) {
      this.programs.skin({ ...uniforms, opacity, pose });
      skin.draw();
    }
  }

  /** Draw the depths of something alone. */
  drawDepths(draw) {
    const { gl } = this;
    gl.colorMask(false, false, false, false);
    draw();
    gl.colorMask(true, true, true, true);
  }

  /** First the depths alone, so that the near side only is seen. */
  drawClear(draw) {
    this.drawDepths(draw);
    draw();
  }

  /** Obstacles hide nothing, neither each other's surroundings nor what is seen through itself: their depths are forgotten. */
  drawAround(skins, solid, uniforms) {
    const { gl, programs, marks } = this;
    if (!skins.length && !marks.clear.some(({ copies }) => copies)) return;
    this.drawClear(() => {
      programs.figure(uniforms);
      for (const copies of marks.clear) copies.draw();
      this.drawSkins(skins, uniforms);
    });
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.drawDepths(() => this.drawSolid(solid, uniforms));
  }

  drawLines(colours, look) {
    const { gl, programs, matrix, canvas, ground } = this;
    gl.depthMask(false);
    for (const { thing, ribbons } of this.marks.lines) {
      const colour = colours.get(thing.layer);
      if (!colour) continue;
      const screen = [canvas.width, canvas.height];
      const dash = thing.dashed ? 0.02 * ground.size : 0;
      programs.line({ matrix, screen, width: 1.5 * look.ratio, dash, paint: [...colour, thing.dashed ? 0.9 : 0.6] });
      ribbons.draw();
    }
    gl.depthMask(true);
  }

  drawGround(look) {
    const { gl, programs, ground, matrix } = this;
    gl.depthMask(false);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.shadow.texture);
    programs.ground({ ...ground, matrix, paint: [...look.soft, look.isDark ? 0.45 : 0.6], darkness: look.isDark ? 0.7 : 0.4, shadow: 0 });
    this.square.draw();
    gl.depthMask(true);
  }
}
