// Pictures that move as a GIF: one palette for all of them, colours by median cut (Heckbert 1982), LZW.

/** Colours of a palette; the most that the format has. */
const COLOURS = 256;
/** Bits of red, green and blue by which colours are counted. */
const BITS = 5;
const SHIFT = 8 - BITS;

const keyOf = (r, g, b) => ((r >> SHIFT) << (2 * BITS)) | ((g >> SHIFT) << BITS) | (b >> SHIFT);

/** Bytes that grow. */
class Bytes {
  constructor() {
    this.bytes = new Uint8Array(1 << 16);
    this.size = 0;
  }

  push(...values) {
    for (const value of values) this.byte(value);
  }

  byte(value) {
    if (this.size === this.bytes.length) {
      const larger = new Uint8Array(2 * this.size);
      larger.set(this.bytes);
      this.bytes = larger;
    }
    this.bytes[this.size++] = value;
  }

  short(value) {
    this.push(value & 255, value >> 8);
  }

  text(letters) {
    for (const letter of letters) this.byte(letter.charCodeAt(0));
  }
}

/**
 * A GIF of pictures that come one by one.
 * @param palette from `paletteOf`
 * @param delay hundredths of a second that each picture is shown
 */
export class Gif {
  constructor(width, height, palette, delay) {
    Object.assign(this, { width, height, palette, delay });
    this.out = new Bytes();
    this.nearest = new Map();
    const { out } = this;
    out.text("GIF89a");
    out.short(width);
    out.short(height);
    // A palette of 256 colours for all pictures.
    out.push(0xf7, 0, 0);
    for (let i = 0; i < COLOURS; i++) out.push(...(palette[i] ?? [0, 0, 0]));
    // It begins anew when it has ended.
    out.push(0x21, 0xff, 11);
    out.text("NETSCAPE2.0");
    out.push(3, 1, 0, 0, 0);
  }

  /** @param pixels red, green, blue and opacity of each pixel, row by row. */
  add(pixels) {
    const { out, width, height } = this;
    out.push(0x21, 0xf9, 4, 0);
    out.short(this.delay);
    out.push(0, 0, 0x2c);
    [0, 0, width, height].forEach((number) => out.short(number));
    out.byte(0);
    const indices = new Uint8Array(width * height);
    for (let i = 0; i < indices.length; i++) indices[i] = this.index(pixels, 4 * i);
    compress(indices, out);
  }

  index(pixels, i) {
    const key = keyOf(pixels[i], pixels[i + 1], pixels[i + 2]);
    let found = this.nearest.get(key);
    if (found === undefined) {
      let least = Infinity;
      this.palette.forEach(([r, g, b], k) => {
        const distance = (r - pixels[i]) ** 2 + (g - pixels[i + 1]) ** 2 + (b - pixels[i + 2]) ** 2;
        if (distance < least) [least, found] = [distance, k];
      });
      this.nearest.set(key, found);
    }
    return found;
  }

  end() {
    this.out.byte(0x3b);
    return this.out.bytes.slice(0, this.out.size);
  }
}

/** At most 256 colours for some pictures: boxes of colours are halved, the one with the most spread first. */
export function paletteOf(pictures) {
  const counts = new Map();
  for (const pixels of pictures) {
    for (let i = 0; i < pixels.length; i += 4) {
      const key = keyOf(pixels[i], pixels[i + 1], pixels[i + 2]);
      const entry = counts.get(key);
      if (entry) {
        entry[3]++;
        for (let k = 0; k < 3; k++) entry[4 + k] += pixels[i + k];
      } else counts.set(key, [...[2 * BITS, BITS, 0].map((bits) => (key >> bits) & 31), 1, ...pixels.slice(i, i + 3)]);
    }
  }
  const box = (colours) => {
    const spans = [0, 1, 2].map((k) => {
      const values = colours.map((colour) => colour[k]);
      return Math.max(...values) - Math.min(...values);
    });
    const axis = spans.indexOf(Math.max(...spans));
    const weight = colours.reduce((sum, colour) => sum + colour[3], 0);
    return { colours, axis, worth: spans[axis] * Math.sqrt(weight), weight };
  };
  const boxes = [box([...counts.values()])];
  while (boxes.length < COLOURS) {
    const next = boxes.reduce((best, each, i) => (each.worth > boxes[best].worth ? i : best), 0);
    const { colours, axis, weight, worth } = boxes[next];
    if (worth === 0) break;
    colours.sort((a, b) => a[axis] - b[axis]);
    let [half, count] = [0, 0];
    while (half < colours.length - 2 && count + colours[half][3] < weight / 2) count += colours[half++][3];
    boxes.splice(next, 1, box(colours.slice(0, half + 1)), box(colours.slice(half + 1)));
  }
  return boxes.map(({ colours, weight }) =>
    [4, 5, 6].map((k) => Math.round(colours.reduce((sum, colour) => sum + colour[k], 0) / weight)));
}

/** Indices by LZW with codes of growing length, in blocks of at most 255 bytes. */
function compress(indices, out) {
  const [bits, clear] = [8, 256];
  out.byte(bits);
  const block = [];
  let [held, count] = [0, 0];
  const send = (byte) => {
    block.push(byte);
    if (block.length === 255) flush();
  };
  const flush = () => {
    if (!block.length) return;
    out.byte(block.length);
    out.push(...block);
    block.length = 0;
  };
  let [size, next] = [bits + 1, clear + 2];
  const code = (value) => {
    held |= value << count;
    count += size;
    while (count >= 8) {
      send(held & 255);
      held >>= 8;
      count -= 8;
    }
  };
  let known = new Map();
  code(clear);
  let prefix = indices[0];
  for (let i = 1; i < indices.length; i++) {
    const key = (prefix << 8) | indices[i];
    const found = known.get(key);
    if (found !== undefined) {
      prefix = found;
      continue;
    }
    code(prefix);
    if (next < 4096) {
      if (next === 1 << size) size++;
      known.set(key, next++);
    } else {
      code(clear);
      known = new Map();
      [size, next] = [bits + 1, clear + 2];
    }
    prefix = indices[i];
  }
  code(prefix);
  code(clear + 1);
  if (count > 0) send(held & 255);
  flush();
  out.byte(0);
}
