// Memory of the graphics card: skins that are written anew for each picture, and unit figures drawn many times.

/** Vertices (point, normal, colour) with triangles between rings of corners. */
export class Skin {
  /** @param grids lists of rings; each grid is so many rings of `corners` vertices, one behind the other. */
  constructor(gl, grids, corners) {
    this.gl = gl;
    const rings = grids.reduce((sum, count) => sum + count, 0);
    this.vertices = new Float32Array(9 * corners * rings);
    const faces = [];
    let first = 0;
    for (const count of grids) {
      for (let ring = 0; ring < count - 1; ring++) {
        for (let i = 0; i < corners; i++) {
          const [a, b] = [first + ring * corners + i, first + ring * corners + ((i + 1) % corners)];
          faces.push(a, b, a + corners, b, b + corners, a + corners);
        }
      }
      first += count * corners;
    }
    this.count = faces.length;
    this.array = gl.createVertexArray();
    this.buffer = gl.createBuffer();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, this.vertices.byteLength, gl.DYNAMIC_DRAW);
    [0, 1, 2].forEach((i) => {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, 3, gl.FLOAT, false, 36, 12 * i);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(faces), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
  }

  /** What was written into `vertices` is drawn from now on. */
  send() {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.vertices);
  }

  draw() {
    const { gl } = this;
    gl.bindVertexArray(this.array);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
  }
}

/** Ribbons along the segments of a line: their vertices know both ends. */
export class Ribbons {
  /** @param segments the six coordinates of both ends and the ways to them, one behind the other. */
  constructor(gl, segments) {
    this.gl = gl;
    const [vertices, faces] = [[], []];
    for (let i = 0; i < segments.length; i += 8) {
      const first = vertices.length / 10;
      for (const [end, side] of [[0, -1], [1, -1], [1, 1], [0, 1]]) {
        vertices.push(end, side, ...segments.slice(i, i + 8));
      }
      faces.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
    this.count = faces.length;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    [[2, 0], [3, 2], [3, 5], [2, 8]].forEach(([size, offset], i) => {
      gl.enableVertexAttribArray(i);
      gl.vertexAttribPointer(i, size, gl.FLOAT, false, 40, 4 * offset);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(faces), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
  }

  draw() {
    const { gl } = this;
    gl.bindVertexArray(this.array);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
  }
}

/** One figure drawn many times, each with numbers of its own. */
export class Copies {
  /** @param sizes how many numbers each attribute of a copy has. */
  constructor(gl, { vertices, sizes: ofCorner }, sizes) {
    this.gl = gl;
    this.numbers = sizes.reduce((sum, size) => sum + size, 0);
    const perCorner = ofCorner.reduce((sum, size) => sum + size, 0);
    this.corners = vertices.length / perCorner;
    this.copies = 0;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    let [place, offset] = [0, 0];
    for (const size of ofCorner) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place++, size, gl.FLOAT, false, 4 * perCorner, offset);
      offset += 4 * size;
    }
    this.buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    offset = 0;
    for (const size of sizes) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 4 * this.numbers, offset);
      gl.vertexAttribDivisor(place++, 1);
      offset += 4 * size;
    }
    gl.bindVertexArray(null);
  }

  send(values) {
    const { gl } = this;
    this.copies = values.length / this.numbers;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.DYNAMIC_DRAW);
  }

  draw() {
    if (!this.copies) return;
    const { gl } = this;
    gl.bindVertexArray(this.array);
    gl.drawArraysInstanced(gl.TRIANGLES, 0, this.corners, this.copies);
  }
}

const turn = (i, count) => [Math.cos((2 * Math.PI * i) / count), Math.sin((2 * Math.PI * i) / count)];

/** x and y on a circle, z from 0 to 1, and -1 or 1 where it belongs to an end. */
export function frustum(corners = 16) {
  const vertices = [];
  for (let i = 0; i < corners; i++) {
    const [a, b] = [turn(i, corners), turn(i + 1, corners)];
    vertices.push(...a, 0, 0, ...b, 0, 0, ...a, 1, 0, ...b, 0, 0, ...b, 1, 0, ...a, 1, 0);
    vertices.push(0, 0, 0, -1, ...a, 0, -1, ...b, 0, -1, 0, 0, 1, 1, ...a, 1, 1, ...b, 1, 1);
  }
  return { vertices, sizes: [4] };
}

export function sphere(around = 24, rings = 14) {
  const vertices = [];
  const point = (i, j) => {
    const [c, s] = turn(i, around);
    const height = Math.PI * (j / rings - 0.5);
    const p = [Math.cos(height) * c, Math.cos(height) * s, Math.sin(height)];
    return [...p, ...p];
  };
  for (let j = 0; j < rings; j++) {
    for (let i = 0; i < around; i++) {
      const [a, b, c, d] = [point(i, j), point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)];
      vertices.push(...a, ...b, ...c, ...b, ...d, ...c);
    }
  }
  return { vertices, sizes: [3, 3] };
}

export function box() {
  const vertices = [];
  for (let axis = 0; axis < 3; axis++) {
    for (const side of [-1, 1]) {
      const corner = (u, v) => {
        const [p, n] = [[0, 0, 0], [0, 0, 0]];
        p[axis] = n[axis] = side;
        p[(axis + 1) % 3] = u;
        p[(axis + 2) % 3] = v;
        return [...p, ...n];
      };
      for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]) vertices.push(...corner(u, v));
    }
  }
  return { vertices, sizes: [3, 3] };
}

/** A square from -1 to 1. */
export function square() {
  return { vertices: [-1, -1, 1, -1, 1, 1, -1, -1, 1, 1, -1, 1], sizes: [2] };
}
