// Letters, lines and colours of plots.

import { ofPage } from "lissom/colours.js";

export const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, Arial, sans-serif';
export const DASHES = { solid: [], dash: [7, 5], dot: [2, 4] };

/** Colours of the page where an element is. */
export const lookOf = (element) => Object.fromEntries(["ink", "soft", "line"].map((name) => [name, ofPage(element, `--${name}`)]));

/** Draw the mark of a point: a diamond, a ring or a disc. */
export function mark(pen, kind, x, y) {
  pen.beginPath();
  if (kind === "diamond") {
    for (const [dx, dy] of [[0, -5.5], [5.5, 0], [0, 5.5], [-5.5, 0]]) pen.lineTo(x + dx, y + dy);
    pen.closePath();
    pen.fill();
  } else if (kind === "ring") {
    pen.lineWidth = 2;
    pen.arc(x, y, 4.5, 0, 2 * Math.PI);
    pen.stroke();
  } else {
    pen.arc(x, y, 3.2, 0, 2 * Math.PI);
    pen.fill();
  }
}
