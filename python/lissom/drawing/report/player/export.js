// Saves what the view shows: a picture, a GIF, a film.

import { nameOf, png, save } from "lissom/files.js";
import { Gif, paletteOf } from "lissom/gif.js";
import { webm } from "lissom/webm.js";

/** Of a GIF: widest picture in pixels, hundredths of a second a picture, most pictures. */
const WIDEST = 560;
const DELAY = 5;
const MOST = 240;
/** Pictures from which the palette of a GIF is made. */
const SAMPLES = 6;
/** Of a film: pictures a second, bits a pixel, and pictures that wait for the encoder. */
const RATE = 30;
const BITS = 0.15;
const WAITING = 2;
/** Codecs as browsers and as films name them, the best first; of VP9 profile 0, level 5.1, 8 bits. */
const CODECS = [["vp09.00.51.08", "V_VP9"], ["vp8", "V_VP8"]];
/** Largest side of a picture in a film, pixels (VP8 has 14 bits for it). */
const LARGEST = 16383;

/** Letters of pictures of a fixed size are as large as on a page that high, pixels. */
const PAGE = 540;

/** Sizes of files: that of the view, or fixed ones; `of` is how the view is laid out for it. */
export const sizes = [
  { name: "as shown", of: (shown) => shown },
  ...[[1920, 1080], [3840, 2160]].map(([width, height]) => ({
    name: `${width} × ${height}`,
    of: () => ({ width: (width * PAGE) / height, height: PAGE, ratio: height / PAGE }),
  })),
];

/** Kinds of files, with what their buttons and names say; a still has those that do not move. */
const KINDS = [
  { name: "PNG", suffix: "png", moves: false, make: picture },
  { name: "PNG, transparent", suffix: "png", moves: false, make: transparent },
  { name: "GIF", suffix: "gif", moves: true, make: gif },
  { name: "WebM", suffix: "webm", moves: true, make: film },
];

/** The kinds of files that this browser can make, of what moves or stands still. */
export const kinds = (isStill) => KINDS.filter(({ make, moves }) =>
  !(moves && isStill) && (make !== film || typeof VideoEncoder !== "undefined"));

/** One picture of all layers of a view, no wider than that. */
export function compose(player, canvas, widest = Infinity) {
  const [first] = player.canvases;
  const part = Math.min(1, widest / first.width);
  const [width, height] = [Math.round(first.width * part), Math.round(first.height * part)];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const pen = canvas.getContext("2d", { willReadFrequently: true });
  pen.clearRect(0, 0, width, height);
  for (const each of player.canvases) pen.drawImage(each, 0, 0, width, height);
  return pen;
}

/** Let the page answer. Timers of pages in the background wait for seconds, messages do not. */
const pause = () => new Promise((resolve) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => {
    port1.close();
    resolve();
  };
  port2.postMessage(0);
});

/**
 * Save a file of a kind.
 * @param tell is told how much is done, from 0 to 1; what it throws ends the work
 */
export async function exportAs({ make, suffix }, player, tell) {
  save(await make(player, document.createElement("canvas"), tell), `${nameOf()}.${suffix}`);
}

async function picture(player, canvas) {
  player.draw();
  compose(player, canvas);
  return png(canvas);
}

async function transparent(player, canvas) {
  player.isTransparent = true;
  try {
    return await picture(player, canvas);
  } finally {
    player.isTransparent = false;
  }
}

async function gif(player, canvas, tell) {
  const { clock } = player;
  const seconds = (clock.end - clock.start) / clock.speed;
  const count = Math.max(1, Math.min(MOST, Math.round((100 * seconds) / DELAY)));
  const pixels = (i) => {
    player.draw(clock.start + (i / Math.max(count, 1)) * (clock.end - clock.start));
    const pen = compose(player, canvas, WIDEST);
    return pen.getImageData(0, 0, canvas.width, canvas.height).data;
  };
  const palette = paletteOf([...Array(SAMPLES).keys()].map((i) => pixels(Math.floor((i * count) / SAMPLES))));
  const made = new Gif(canvas.width, canvas.height, palette, Math.round((100 * seconds) / count) || DELAY);
  for (let i = 0; i < count; i++) {
    made.add(pixels(i));
    tell(i / count);
    await pause();
  }
  return new Blob([made.end()], { type: "image/gif" });
}

/** Every picture of a film is drawn, however long that takes: their times are those of the motion. */
async function film(player, canvas, tell) {
  const { clock } = player;
  const count = Math.max(1, Math.round((RATE * (clock.end - clock.start)) / clock.speed)) + 1;
  compose(player, canvas);
  // Colours have half as many pixels in both directions.
  const [width, height] = [canvas.width, canvas.height].map((side) => side - (side % 2));
  const [codec, config] = await codecOf(width, height);
  const pictures = [];
  let problem = null;
  const encoder = new VideoEncoder({
    output: (chunk) => {
      const bytes = new Uint8Array(chunk.byteLength);
      chunk.copyTo(bytes);
      pictures.push({ time: Math.round(chunk.timestamp / 1000), isWhole: chunk.type === "key", bytes });
    },
    error: (error) => {
      problem = error;
    },
  });
  try {
    encoder.configure(config);
    for (let i = 0; i < count; i++) {
      player.draw(Math.min(clock.start + (i / RATE) * clock.speed, clock.end));
      compose(player, canvas);
      const visibleRect = { x: 0, y: 0, width, height };
      const frame = new VideoFrame(canvas, { timestamp: Math.round((1e6 * i) / RATE), alpha: "discard", visibleRect });
      encoder.encode(frame, { keyFrame: i % RATE === 0 });
      frame.close();
      tell(i / count);
      do await pause(); while (encoder.encodeQueueSize > WAITING && !problem);
      if (problem) throw problem;
    }
    await encoder.flush();
  } finally {
    if (encoder.state !== "closed") encoder.close();
  }
  if (problem) throw problem;
  return webm({ codec, width, height, duration: (1000 * count) / RATE, pictures });
}

/** The first codec that can, as films name it, and how it is set. */
async function codecOf(width, height) {
  if (Math.max(width, height) > LARGEST) throw new Error(`films have at most ${LARGEST} pixels to a side`);
  for (const [codec, name] of CODECS) {
    const config = { codec, width, height, framerate: RATE, bitrate: BITS * RATE * width * height };
    if ((await VideoEncoder.isConfigSupported(config)).supported) return [name, config];
  }
  throw new Error("this browser encodes neither VP9 nor VP8");
}
