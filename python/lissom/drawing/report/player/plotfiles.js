// Files of plots: vectors, pixels, numbers.

import { nameOf, png, save } from "lissom/files.js";
import { FINE, inLight } from "lissom/paper.js";
import { DASHES, FONT, lookOf, mark } from "lissom/strokes.js";
import { SvgPen } from "lissom/svg.js";

/** Of the legend: height of a line, length of a sample, and room after a sample and after a name, pixels. */
const LINE = 22;
const SAMPLE = 22;
const GAP = 6;
const APART = 18;

/** Buttons that save the plots of a figure. */
export function buttons(plots) {
  const made = document.createElement("div");
  made.className = "group files";
  made.setAttribute("role", "group");
  made.setAttribute("aria-label", "Save the plots");
  for (const [kind, make] of Object.entries({ SVG: vectors, PNG: pixels, CSV: numbers })) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: kind });
    button.setAttribute("aria-label", `save the plots as ${kind}`);
    button.addEventListener("click", async () => {
      const [{ plot }] = plots;
      const title = (plot.title || plot.y.title || "plot").replace(/ \([^)]*\)$/, "");
      save(await make(plots), `${nameOf(title)}.${kind.toLowerCase()}`);
    });
    made.append(button);
  }
  return made;
}

async function vectors(plots) {
  let pen;
  draw(plots, (width, height) => {
    pen = new SvgPen(width, height);
    return pen;
  });
  return new Blob([pen.end()], { type: "image/svg+xml" });
}

async function pixels(plots) {
  const canvas = document.createElement("canvas");
  draw(plots, (width, height) => {
    Object.assign(canvas, { width: width * FINE, height: height * FINE });
    const pen = canvas.getContext("2d", { willReadFrequently: true });
    pen.scale(FINE, FINE);
    pen.fillStyle = "#ffffff";
    pen.fillRect(0, 0, width, height);
    return pen;
  });
  return png(canvas);
}

/** Draw the plots as they stand on the page, in colours for paper, with a legend above them. @param penOf the pen for a size. */
function draw(plots, penOf) {
  const boxes = plots.map(({ element }) => element.getBoundingClientRect());
  const [left, top] = ["left", "top"].map((side) => Math.min(...boxes.map((box) => box[side])));
  const [right, bottom] = ["right", "bottom"].map((side) => Math.max(...boxes.map((box) => box[side])));
  const width = Math.ceil(right - left);
  const [entries, lines] = layOut(plots, width);
  const above = lines * LINE;
  const pen = penOf(width, Math.ceil(bottom - top) + above);
  const look = inLight(() => lookOf(plots[0].element));
  pen.font = FONT;
  for (const entry of entries) drawEntry(pen, entry, look);
  plots.forEach((plot, i) => {
    pen.save();
    pen.translate(boxes[i].left - left, boxes[i].top - top + above);
    plot.render(pen, boxes[i].width, plot.height, look);
    pen.restore();
  });
}

/** Curves of a legend with their places, and the number of its lines; one curve needs none. */
function layOut(plots, width) {
  const found = new Map();
  for (const curve of plots.flatMap(({ curves }) => curves)) if (curve.name) found.set(curve.name, curve);
  if (found.size < 2) return [[], 0];
  const ruler = document.createElement("canvas").getContext("2d");
  ruler.font = FONT;
  let [x, line] = [0, 0];
  const entries = [...found.values()].map((curve) => {
    const wide = SAMPLE + GAP + ruler.measureText(curve.name).width;
    if (x > 0 && x + wide > width) [x, line] = [0, line + 1];
    const entry = { curve, x, y: (line + 0.5) * LINE };
    x += wide + APART;
    return entry;
  });
  return [entries, line + 1];
}

function drawEntry(pen, { curve, x, y }, look) {
  pen.strokeStyle = pen.fillStyle = curve.colour;
  pen.lineWidth = 2;
  pen.setLineDash(curve.joined ? DASHES[curve.style] : []);
  pen.beginPath();
  if (curve.joined) {
    pen.moveTo(x, y);
    pen.lineTo(x + SAMPLE, y);
    pen.stroke();
  } else {
    mark(pen, curve.mark, x + 0.5 * SAMPLE, y);
  }
  pen.setLineDash([]);
  pen.fillStyle = look.ink;
  pen.textAlign = "left";
  pen.textBaseline = "middle";
  pen.fillText(curve.name, x + SAMPLE + GAP, y);
}

/** Columns of what is shown: curves over the same values stand beside these. */
async function numbers(plots) {
  const columns = [];
  const known = new Map();
  for (const each of plots) {
    const { plot } = each;
    for (const { name, x, y } of each.curves) {
      const before = known.get(x);
      if (before === undefined) {
        const group = [column(across(plots, plot), x)];
        known.set(x, group);
        columns.push(group);
      }
      known.get(x).push(column([plot.title, plot.y.title, name].filter(Boolean).join(": "), y));
    }
  }
  const all = columns.flat();
  const count = Math.max(0, ...all.map(({ values }) => values.length));
  const rows = [...Array(count).keys()].map((i) => all.map(({ values, text }) => (i < values.length ? text(values[i]) : "")));
  const lines = [all.map(({ title }) => quoted(title)), ...rows].map((cells) => cells.join(","));
  return new Blob([`${lines.join("\r\n")}\r\n`], { type: "text/csv;charset=utf-8" });
}

/** The title of what is across: of plots above each other only the last one has it. */
const across = (plots, plot) => plot.x.title || plots.at(-1).plot.x.title || "x";

/** Digits of a number. */
const DIGITS = 7;

/** A column with as many decimals as its numbers have. */
function column(title, { values, step }) {
  const places = Math.min(Math.max(0, Math.ceil(-Math.log10(step))), 100);
  const exact = (value) => (step > 0 ? Number(value.toFixed(places)) : value);
  const text = (value) => (Number.isFinite(value) ? String(Number(exact(value).toPrecision(DIGITS))) : "");
  return { title, values, text };
}

/** As RFC 4180 says. */
const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
