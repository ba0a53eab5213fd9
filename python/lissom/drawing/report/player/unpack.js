// Reads the documents that `packing.py` packs: arrays of 8 to 32 bits, deflated, as text.

/** The document with its arrays as {shape, values, step}: values are multiples of the step, if there is one. */
export async function unpack({ document, data }) {
  const bytes = await inflate(data);
  const known = new Map();
  const read = (value) => {
    if (Array.isArray(value)) return value.map(read);
    if (value === null || typeof value !== "object") return value;
    if (!value.array) return Object.fromEntries(Object.entries(value).map(([key, inner]) => [key, read(inner)]));
    const [first, type] = value.array;
    const key = first + type;
    if (!known.has(key)) known.set(key, numbers(bytes, ...value.array));
    return known.get(key);
  };
  return read(document);
}

async function inflate(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function numbers(bytes, first, type, shape, low, step) {
  const count = shape.reduce((product, side) => product * side, 1);
  const values = new Float64Array(count);
  if (type === "f4") {
    const view = new DataView(bytes.buffer, bytes.byteOffset + first, 4 * count);
    for (let i = 0; i < count; i++) values[i] = view.getFloat32(4 * i, true);
    return { shape, values, step: 0 };
  }
  const bytesOfEach = Number(type[1]);
  const largest = 256 ** bytesOfEach - 1;
  const row = count / (shape[0] || 1);
  const scales = Array.isArray(low) ? low.length : 1;
  const [lows, steps] = [[low].flat(), [step].flat()];
  const whole = new Uint32Array(count);
  for (let i = 0; i < count; i++) {
    let change = 0;
    for (let k = 0; k < bytesOfEach; k++) change += bytes[first + k * count + i] * 256 ** k;
    whole[i] = (i < row ? change : whole[i - row] + change) % (largest + 1);
    const scale = i % scales;
    values[i] = whole[i] === largest ? NaN : lows[scale] + whole[i] * steps[scale];
  }
  return { shape, values, step: Math.max(...steps) };
}
