// Skins of rods with their true sections, and of strands: bars from point to point.

import { Skin } from "lissom/meshes.js";
import { across, axes, cross, dot, mix, scale, subtract, unit } from "lissom/vectors.js";

/** Corners of a section: six for each side of a rectangle. */
const CORNERS = 24;
const STRAND_CORNERS = 12;

/** The outline of a section: its points and its normals, for half extents of one. */
const outlines = [false, true].map((isSquare) =>
  [...Array(CORNERS).keys()].map((i) => {
    if (!isSquare) {
      const angle = (2 * Math.PI * (i + 0.5)) / CORNERS - Math.PI / 4;
      return [Math.cos(angle), Math.sin(angle), Math.cos(angle), Math.sin(angle)];
    }
    const along = (2 * (i % 6)) / 5 - 1;
    return [[1, along, 1, 0], [-along, 1, 0, 1], [-1, -along, -1, 0], [along, -1, 0, -1]][Math.floor(i / 6)];
  }));

/** Values of a thing between two shapes: reads arrays of one shape or of all. */
export function between({ shape, values }, at, part) {
  const size = values.length / shape[0];
  const first = shape[0] > 1 ? at * size : 0;
  const second = shape[0] > 1 && at + 1 < shape[0] ? first + size : first;
  return (i) => mix(values[first + i], values[second + i], part);
}

/** A rod. */
export class Tube {
  constructor(gl, thing) {
    this.thing = thing;
    this.opacity = thing.opacity;
    this.stations = thing.stations.values.length;
    this.isHollow = thing.hole.values.some((hole) => hole > 0);
    this.skin = new Skin(gl, [this.stations, 2, 2, ...(this.isHollow ? [this.stations] : [])], CORNERS);
    this.slopes = this.slopesOfSections();
  }

  /** How fast the section grows along the rod. */
  slopesOfSections() {
    const { stations, half } = this.thing;
    const size = (k) => 0.5 * (half.values[2 * k] + half.values[2 * k + 1]);
    return [...Array(this.stations).keys()].map((k) => {
      const [a, b] = [Math.max(k - 1, 0), Math.min(k + 1, this.stations - 1)];
      return (size(b) - size(a)) / (stations.values[b] - stations.values[a] || 1);
    });
  }

  /** @param paint the colour of a station. */
  update(at, part, paint) {
    const { centres, turns, half, hole, square } = this.thing;
    const [centre, turned] = [between(centres, at, part), between(turns, at, part)];
    const { vertices } = this.skin;
    let place = 0;
    const write = (point, normal, colour) => {
      for (const vector of [point, normal, colour]) {
        vertices[place++] = vector[0];
        vertices[place++] = vector[1];
        vertices[place++] = vector[2];
      }
    };
    const rings = [...Array(this.stations).keys()].map((k) => ({
      centre: [0, 1, 2].map((i) => centre(3 * k + i)),
      axes: axes(...[0, 1, 2, 3].map((i) => turned(4 * k + i))),
      half: [half.values[2 * k], half.values[2 * k + 1]],
      hole: hole.values[k],
      outline: outlines[square[k]],
      slope: this.slopes[k],
      colour: paint(k),
    }));
    const ring = (r, size, normal) => {
      for (const corner of r.outline) {
        const [y, z] = [size * r.half[0] * corner[0], size * r.half[1] * corner[1]];
        const [, a, b] = r.axes;
        const point = [0, 1, 2].map((i) => r.centre[i] + y * a[i] + z * b[i]);
        write(point, normal ?? wall(r, corner, size < 1 ? -1 : 1), r.colour);
      }
    };
    for (const r of rings) ring(r, 1);
    const last = rings[this.stations - 1];
    for (const [r, side] of [[rings[0], -1], [last, 1]]) {
      ring(r, 1, scale(r.axes[0], side));
      ring(r, r.hole, scale(r.axes[0], side));
    }
    if (this.isHollow) for (const r of rings) ring(r, Math.min(r.hole, 0.999));
    this.skin.send();
  }
}

/** The normal of a wall at a corner; of ellipses across their outline. */
function wall({ half, axes: [x, y, z], slope }, [, , ny, nz], side) {
  const normal = unit([0, ny / half[0], nz / half[1]]);
  const tilted = [0, 1, 2].map((i) => normal[1] * y[i] + normal[2] * z[i] - slope * x[i]);
  return scale(unit(tilted), side);
}

/** Bars from point to point. */
export class Strand {
  constructor(gl, thing) {
    this.thing = thing;
    this.opacity = thing.opacity;
    const { shape, values } = thing.points;
    this.runs = [];
    let run = [];
    for (let i = 0; i <= shape[1]; i++) {
      if (i < shape[1] && !Number.isNaN(values[3 * i])) run.push(i);
      else if (run.length) {
        if (run.length > 1) this.runs.push(run);
        run = [];
      }
    }
    // Each run has an end before and one behind.
    this.skin = new Skin(gl, this.runs.map((indices) => indices.length + 2), STRAND_CORNERS);
  }

  update(at, part, colour) {
    const point = between(this.thing.points, at, part);
    const radius = between(this.thing.radius, at, part)(0);
    const { vertices } = this.skin;
    let place = 0;
    const ring = (centre, first, second, size, end) => {
      for (let i = 0; i < STRAND_CORNERS; i++) {
        const [c, s] = [Math.cos((2 * Math.PI * i) / STRAND_CORNERS), Math.sin((2 * Math.PI * i) / STRAND_CORNERS)];
        for (let k = 0; k < 3; k++) {
          const outward = c * first[k] + s * second[k];
          vertices[place + k] = centre[k] + size * outward;
          vertices[place + 3 + k] = end ? end[k] : outward;
          vertices[place + 6 + k] = colour[k];
        }
        place += 9;
      }
    };
    for (const run of this.runs) {
      const points = run.map((i) => [point(3 * i), point(3 * i + 1), point(3 * i + 2)]);
      const last = points.length - 1;
      let first = null;
      points.forEach((here, k) => {
        const along = unit(subtract(points[Math.min(k + 1, last)], points[Math.max(k - 1, 0)]));
        // The corners turn as little as they can.
        first = first ? unit(subtract(first, scale(along, dot(first, along)))) : across(along);
        const second = cross(along, first);
        if (k === 0) ring(here, first, second, 0, scale(along, -1));
        ring(here, first, second, radius);
        if (k === last) ring(here, first, second, 0, along);
      });
    }
    this.skin.send();
  }
}
