// What is written over the view: axes, the scale of colours, the size of the grid, the time.

import { sample } from "lissom/colours.js";
import { dot } from "lissom/vectors.js";
import { roundLength, shortly } from "lissom/ticks.js";

const AXES = ["#d9485f", "#2ca25f", "#3a7bd5"];
/** Longest bar, relative to the width of the view. */
const BAR = 0.2;
const FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, Arial, sans-serif';

export class Overlay {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
  }

  /** @param label the time in words. */
  draw(stage, look, label) {
    const { canvas, pen } = this;
    const [width, height] = [canvas.width / look.ratio, canvas.height / look.ratio];
    pen.setTransform(look.ratio, 0, 0, look.ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.font = `12px ${FONT}`;
    pen.textBaseline = "middle";
    this.axes(stage.camera.frame(), look, 44, height - 44);
    pen.fillStyle = look.softText;
    pen.textAlign = "right";
    if (!stage.hidden.has("floor") && !stage.camera.isParallel) pen.fillText(`grid ${shortly(stage.cell)} m`, width - 12, height - 14);
    if (stage.camera.isParallel) this.bar(stage.camera, look, width, height);
    pen.textAlign = "left";
    pen.fillStyle = look.inkText;
    pen.font = `600 13px ${FONT}`;
    if (label) pen.fillText(label, 12, 17);
    if (stage.tubes.length) this.scale(stage, look, width);
  }

  /** A length to which everything is to scale. */
  bar({ reach }, look, width, height) {
    const { pen } = this;
    const metre = height / (2 * reach);
    const length = roundLength((BAR * width) / metre);
    const [x, y] = [width - 12 - length * metre, height - 34];
    pen.fillStyle = look.inkText;
    pen.fillRect(x, y, length * metre, 3);
    pen.textAlign = "center";
    pen.fillText(`${shortly(length)} m`, x + 0.5 * length * metre, y - 10);
  }

  axes({ right, up, back }, look, x, y) {
    const { pen } = this;
    const axes = [0, 1, 2].map((axis) => {
      const a = [0, 0, 0];
      a[axis] = 1;
      return { axis, x: dot(a, right), y: -dot(a, up), depth: dot(a, back) };
    });
    axes.sort((a, b) => a.depth - b.depth);
    pen.lineWidth = 2;
    pen.textAlign = "center";
    for (const { axis, x: dx, y: dy } of axes) {
      pen.strokeStyle = pen.fillStyle = AXES[axis];
      pen.beginPath();
      pen.moveTo(x, y);
      pen.lineTo(x + 24 * dx, y + 24 * dy);
      pen.stroke();
      if (Math.hypot(dx, dy) > 0.25) pen.fillText("xyz"[axis], x + 33 * dx, y + 33 * dy);
    }
  }

  scale({ way, scene }, look, width) {
    const { pen } = this;
    const long = Math.min(170, 0.42 * width);
    const [x, y] = [width - long - 14, 26];
    pen.font = `12px ${FONT}`;
    pen.fillStyle = look.softText;
    pen.textAlign = "right";
    pen.fillText(way.name, width - 14, 14);
    const steps = way.segments ?? 64;
    for (let i = 0; i < steps; i++) {
      const colour = sample(scene.scale, i / (steps - 1)).map((value) => Math.round(255 * value));
      pen.fillStyle = `rgb(${colour})`;
      pen.fillRect(x + (i * long) / steps, y, long / steps + 0.6, 7);
    }
    const ends = way.segments ? ["1", String(way.segments)] : way.high === undefined ? ["base", "tip"]
      : [shortly(way.low), shortly(way.high)];
    pen.fillStyle = look.softText;
    pen.textAlign = "left";
    pen.fillText(ends[0], x, y + 16);
    pen.textAlign = "right";
    pen.fillText(ends[1], x + long, y + 16);
  }
}
