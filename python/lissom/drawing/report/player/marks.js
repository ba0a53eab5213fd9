// Arrows, bodies, dots and lines: unit figures drawn many times.

import { Copies, Ribbons, box, frustum, sphere } from "lissom/meshes.js";
import { add, length, scale } from "lissom/vectors.js";
import { between } from "lissom/tubes.js";

/** All marks of a view together. */
export class Marks {
  constructor(gl, things) {
    this.things = things.filter(({ kind }) => ["arrows", "solid", "dots"].includes(kind));
    this.lines = things.filter(({ kind }) => kind === "line").map((thing) => ({ thing, ribbons: lineOf(gl, thing) }));
    this.frustums = new Copies(gl, frustum(), [3, 3, 2, 3]);
    const figures = [3, 4, 3, 4];
    this.spheres = new Copies(gl, sphere(), figures);
    this.boxes = new Copies(gl, box(), figures);
    /** Those that are seen through. */
    this.clear = [new Copies(gl, sphere(), figures), new Copies(gl, box(), figures)];
  }

  /** @param colours colours of the layers that are shown. */
  update(at, part, colours) {
    const [frustums, solid, clear] = [[], [[], []], [[], []]];
    for (const thing of this.things) {
      const colour = colours.get(thing.layer);
      if (!colour) continue;
      const [spheres, boxes] = thing.opacity < 1 ? clear : solid;
      if (thing.kind === "arrows") arrows(thing, at, part, colour, frustums);
      else if (thing.kind === "dots") dots(thing, at, part, colour, spheres);
      else body(thing, at, part, colour, thing.form === "box" ? boxes : spheres);
    }
    this.frustums.send(frustums);
    this.spheres.send(solid[0]);
    this.boxes.send(solid[1]);
    this.clear.forEach((copies, i) => copies.send(clear[i]));
  }
}

function arrows(thing, at, part, colour, frustums) {
  const [tail, vector] = [between(thing.tails, at, part), between(thing.vectors, at, part)];
  for (let i = 0; i < thing.tails.shape[1]; i++) {
    const start = [0, 1, 2].map((k) => tail(3 * i + k));
    const arrow = [0, 1, 2].map((k) => vector(3 * i + k));
    const size = length(arrow);
    // Numbers are rounded: what is as short as that is none.
    if (!(size > 1e-3 * thing.head)) continue;
    const head = Math.min(thing.head, thing.most * size);
    const neck = add(start, scale(arrow, 1 - head / size));
    const share = head / thing.head;
    if (head < size) frustums.push(...start, ...neck, share * thing.radius, share * thing.radius, ...colour);
    frustums.push(...neck, ...add(start, arrow), share * thing.headRadius, 0, ...colour);
  }
}

function dots(thing, at, part, colour, spheres) {
  const point = between(thing.points, at, part);
  for (let i = 0; i < thing.points.shape[1]; i++) {
    const size = [thing.radius, thing.radius, thing.radius];
    spheres.push(point(3 * i), point(3 * i + 1), point(3 * i + 2), 1, 0, 0, 0, ...size, ...colour, thing.opacity);
  }
}

function body(thing, at, part, colour, figures) {
  const [centre, turned] = [between(thing.centres, at, part), between(thing.turns, at, part)];
  const turn = [0, 1, 2, 3].map(turned);
  const size = Math.hypot(...turn) || 1;
  figures.push(...[0, 1, 2].map(centre), ...turn.map((number) => number / size), ...thing.size, ...colour, thing.opacity);
}

function lineOf(gl, { points: { shape, values } }) {
  const numbers = [];
  let way = 0;
  for (let i = 0; i + 1 < shape[1]; i++) {
    const ends = [...values.slice(3 * i, 3 * i + 6)];
    if (ends.some(Number.isNaN)) continue;
    const further = way + Math.hypot(ends[3] - ends[0], ends[4] - ends[1], ends[5] - ends[2]);
    numbers.push(...ends, way, further);
    way = further;
  }
  return new Ribbons(gl, numbers);
}
