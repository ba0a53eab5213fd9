// Letters, lines and colours of plots.

import { ofPage } from "lissom/colours.js";

export const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, Arial, sans-serif';
export const DASHES = { solid: [], dash: [7, 5], dot: [2, 4] };

/** Colours of the page where an element is. */
export const lookOf = (element) => Object.fromEntries(["ink", "soft", "line"].map((name) => [name, ofPage(element, `--${name}`)]));
