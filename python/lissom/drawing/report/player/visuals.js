// Visuals of links: meshes that move as a whole.

import { parse } from "lissom/colours.js";
import { axes } from "lissom/vectors.js";
import { between } from "lissom/tubes.js";

/** A mesh, written once to the memory of the graphics card; its pose goes to the program. */
export class Visual {
  constructor(gl, thing) {
    this.gl = gl;
    this.thing = thing;
    this.opacity = thing.opacity;
    this.own = thing.colour ? parse(thing.colour) : null;
    const { corners, normals, faces } = thing;
    const vertices = new Float32Array(2 * corners.values.length);
    for (let i = 0; i < corners.values.length; i += 3) {
      vertices.set(corners.values.subarray(i, i + 3), 2 * i);
      vertices.set(normals.values.subarray(i, i + 3), 2 * i + 3);
    }
    this.count = faces.values.length;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
    [0, 1].forEach((i) => {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 24, 12 * i);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    // Packed numbers are multiples of a step: whole ones are rounded.
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(faces.values, Math.round), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    this.skin = this;
  }

  update(at, part, colour) {
    const [centre, turned] = [between(this.thing.centres, at, part), between(this.thing.turns, at, part)];
    const columns = axes(...[0, 1, 2, 3].map(turned));
    this.pose = [...columns.flatMap((axis) => [...axis, 0]), centre(0), centre(1), centre(2), 1];
    this.colour = this.own ?? colour;
  }

  draw() {
    const { gl } = this;
    gl.bindVertexArray(this.array);
    // All of one colour: not an array.
    gl.vertexAttrib3f(2, ...this.colour);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
  }
}
