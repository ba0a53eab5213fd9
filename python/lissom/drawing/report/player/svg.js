// Draws with vectors what plots draw on a canvas: a pen with the methods and settings of CanvasRenderingContext2D that they use.

/** From the baseline of letters to where a text is held, relative to their size. */
const BASELINES = { alphabetic: 0, top: 0.78, middle: 0.34, bottom: -0.22 };
const ANCHORS = { left: "start", center: "middle", right: "end" };

const escape = (text) => text.replace(/[&<>"]/g, (letter) => `&#${letter.codePointAt(0)};`);
/** Hundredths of a pixel are enough. */
const brief = (value) => String(Number(value.toFixed(2)));

export class SvgPen {
  constructor(width, height) {
    Object.assign(this, { width, height });
    this.ruler = document.createElement("canvas").getContext("2d");
    this.parts = [];
    this.path = [];
    this.clips = 0;
    this.saved = [];
    /** The matrix of the drawing: x' = a x + c y + e, y' = b x + d y + f. */
    this.matrix = [1, 0, 0, 1, 0, 0];
    this.groups = 0;
    this.dash = [];
    Object.assign(this, { lineWidth: 1, lineJoin: "miter", strokeStyle: "#000", fillStyle: "#000", textAlign: "left", textBaseline: "alphabetic" });
  }

  set font(font) {
    this.ruler.font = font;
  }

  get font() {
    return this.ruler.font;
  }

  measureText(text) {
    return this.ruler.measureText(text);
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  save() {
    const { matrix, groups, dash, lineWidth, lineJoin, strokeStyle, fillStyle, textAlign, textBaseline } = this;
    this.saved.push({ matrix, groups, dash, lineWidth, lineJoin, strokeStyle, fillStyle, textAlign, textBaseline });
  }

  restore() {
    const before = this.saved.pop();
    for (; this.groups > before.groups; this.groups--) this.parts.push("</g>");
    Object.assign(this, before);
  }

  translate(x, y) {
    const [a, b, c, d, e, f] = this.matrix;
    this.matrix = [a, b, c, d, a * x + c * y + e, b * x + d * y + f];
  }

  rotate(angle) {
    const [a, b, c, d, e, f] = this.matrix;
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    this.matrix = [a * cos + c * sin, b * cos + d * sin, c * cos - a * sin, d * cos - b * sin, e, f];
  }

  at(x, y) {
    const [a, b, c, d, e, f] = this.matrix;
    return `${brief(a * x + c * y + e)} ${brief(b * x + d * y + f)}`;
  }

  beginPath() {
    this.path = [];
  }

  moveTo(x, y) {
    this.path.push(`M${this.at(x, y)}`);
  }

  lineTo(x, y) {
    this.path.push(`${this.path.length ? "L" : "M"}${this.at(x, y)}`);
  }

  closePath() {
    this.path.push("Z");
  }

  rect(x, y, width, height) {
    this.moveTo(x, y);
    this.lineTo(x + width, y);
    this.lineTo(x + width, y + height);
    this.lineTo(x, y + height);
    this.closePath();
  }

  /** A whole circle, which is all that plots draw. */
  arc(x, y, radius) {
    const half = `A${brief(radius)} ${brief(radius)} 0 1 0`;
    this.path.push(`M${this.at(x - radius, y)}${half} ${this.at(x + radius, y)}${half} ${this.at(x - radius, y)}Z`);
  }

  clip() {
    const name = `clip-${this.clips++}`;
    this.parts.push(`<clipPath id="${name}"><path d="${this.path.join("")}"/></clipPath><g clip-path="url(#${name})">`);
    this.groups++;
  }

  stroke() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    this.parts.push(`<path d="${this.path.join("")}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" `
      + `stroke-linejoin="${this.lineJoin}"${dash}/>`);
  }

  fill() {
    this.parts.push(`<path d="${this.path.join("")}" fill="${this.fillStyle}"/>`);
  }

  fillText(text, x, y) {
    const size = parseFloat(this.font.match(/([\d.]+)px/)[1]);
    const [a, b, c, d, e, f] = this.matrix;
    const low = y + BASELINES[this.textBaseline] * size;
    const isUpright = b === 0 && c === 0;
    const place = isUpright ? `x="${brief(x + e)}" y="${brief(low + f)}"`
      : `x="${brief(x)}" y="${brief(low)}" transform="matrix(${[a, b, c, d, e, f].map(brief).join(" ")})"`;
    this.parts.push(`<text ${place} font-size="${size}" text-anchor="${ANCHORS[this.textAlign]}" fill="${this.fillStyle}">${escape(text)}</text>`);
  }

  /** The drawing as a file. */
  end() {
    const { width, height, parts } = this;
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" `
      + `font-family="Helvetica, Arial, 'DejaVu Sans', sans-serif">\n<rect width="100%" height="100%" fill="#ffffff"/>\n${parts.join("\n")}\n</svg>\n`;
  }
}
