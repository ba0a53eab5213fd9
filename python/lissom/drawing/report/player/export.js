// Saves what the view shows: a picture, a GIF, a film.

import { Gif, paletteOf } from "lissom/gif.js";

/** Of a GIF: widest picture in pixels, hundredths of a second a picture, most pictures. */
const WIDEST = 560;
const DELAY = 5;
const MOST = 240;
/** Pictures from which the palette of a GIF is made. */
const SAMPLES = 6;
/** Of a film: bits a second, milliseconds a piece of the file, bytes that are no picture yet, and pieces to wait for one. */
const BITS = 8e6;
const PIECE = 100;
const HEADER = 400;
const PATIENCE = 50;

/** The kinds of files that this browser can make. */
export const kinds = () => ["PNG", "GIF", ...(filmType() ? ["WebM"] : [])];

const filmType = () => typeof MediaRecorder !== "undefined" && "captureStream" in HTMLCanvasElement.prototype
  && ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find((type) => MediaRecorder.isTypeSupported(type));

/** One picture of all layers of a view, no wider than that. */
export function compose(player, canvas, widest = Infinity) {
  const [first] = player.canvases;
  const part = Math.min(1, widest / first.width);
  const [width, height] = [Math.round(first.width * part), Math.round(first.height * part)];
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const pen = canvas.getContext("2d", { willReadFrequently: true });
  for (const each of player.canvases) pen.drawImage(each, 0, 0, width, height);
  return pen;
}

const pause = (milliseconds = 0) => new Promise((resolve) => setTimeout(resolve, milliseconds));

function save(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1e4);
}

/**
 * Make a file of a kind; what it holds.
 * @param tell is told how much is done, from 0 to 1
 */
export async function make(kind, player, tell) {
  const canvas = document.createElement("canvas");
  if (kind === "PNG") {
    player.draw();
    compose(player, canvas);
    return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
  }
  return kind === "GIF" ? gif(player, canvas, tell) : film(player, canvas, tell);
}

export async function exportAs(kind, player, name, tell) {
  save(await make(kind, player, tell), `${name}.${kind.toLowerCase()}`);
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
  player.draw();
  return new Blob([made.end()], { type: "image/gif" });
}

async function film(player, canvas, tell) {
  const { clock } = player;
  compose(player, canvas);
  const stream = canvas.captureStream(0);
  const [track] = stream.getVideoTracks();
  const recorder = new MediaRecorder(stream, { mimeType: filmType(), videoBitsPerSecond: BITS });
  const parts = [];
  recorder.addEventListener("dataavailable", ({ data }) => parts.push(data));
  const ended = new Promise((resolve) => recorder.addEventListener("stop", resolve));
  recorder.start(PIECE);
  const began = performance.now();
  await new Promise((resolve) => {
    const next = () => {
      const time = clock.start + ((performance.now() - began) / 1000) * clock.speed;
      player.draw(Math.min(time, clock.end));
      compose(player, canvas);
      track.requestFrame();
      tell((time - clock.start) / (clock.end - clock.start || 1));
      if (time < clock.end) requestAnimationFrame(next);
      else resolve();
    };
    next();
  });
  // Encoders start late: the last picture stays until there is one in the file.
  const size = () => parts.reduce((sum, part) => sum + part.size, 0);
  for (let i = 0; i < PATIENCE && size() < HEADER; i++) {
    track.requestFrame();
    await pause(PIECE);
  }
  recorder.stop();
  await ended;
  player.draw();
  return new Blob(parts, { type: "video/webm" });
}
