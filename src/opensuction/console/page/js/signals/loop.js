// The transmission's loop: head against tip. No sensor tells where the tip is: shown is between which
// two depths it can be, and where the controller wants it.

import { make, say } from "../dom.js";
import { text } from "../text.js";
import { LOOP } from "./preset.js";
import { limitsOf } from "./scale.js";
import { colours } from "./strip.js";

const SIZE_PX = 300;
const LEFT_PX = 52;
const BELOW_PX = 38;
const POINTS = 1500;
const EVERY_MS = 100;

export class Loop {
  constructor() {
    this.drawn_ms = -EVERY_MS;
    this.canvas = make("canvas", { class: "loop-canvas", role: "img", "aria-label": text.signals.loop.describe });
    this.note = make("p", { class: "loop-note" });
    this.element = make("section", { class: "loop", "aria-label": text.signals.loop.title },
      make("h2", {}, text.signals.loop.title), this.canvas, this.note);
  }

  /** isLive: again in a moment, so not each time. */
  draw(buffer, from_s, to_s, isLive) {
    const now_ms = performance.now();
    if (isLive && now_ms - this.drawn_ms < EVERY_MS) return;
    this.drawn_ms = now_ms;
    const places = LOOP.map((name) => buffer.channels.findIndex((one) => one.name === name));
    if (places.includes(-1)) return;
    const points = this.take(buffer, places, buffer.find(from_s), buffer.find(to_s));
    const all = this.take(buffer, places, buffer.first, buffer.next);
    const ratio = devicePixelRatio;
    const { canvas } = this;
    canvas.width = SIZE_PX * ratio;
    canvas.height = SIZE_PX * ratio;
    const ctx = canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.now ??= colours();
    if (points.length < 2) {
      say(this.note, text.signals.loop.none);
      return;
    }
    say(this.note, text.signals.loop.note);
    this.paint(ctx, points, all);
  }

  take(buffer, places, begin, end) {
    // A power of two, and rows that it divides: while rows come the same ones are taken again.
    const step = 2 ** Math.max(Math.ceil(Math.log2((end - begin) / POINTS)), 0);
    const points = [];
    for (let row = Math.ceil(begin / step) * step; row < end; row += step) {
      const point = places.map((place) => buffer.value(place, row));
      if (point.every(Number.isFinite)) points.push(point);
    }
    return points;
  }

  paint(ctx, points, all) {
    const heads = all.map((point) => point[0]);
    const tips = all.flatMap((point) => point.slice(1));
    const x = this.axis(limitsOf("mm", least(heads), most(heads)), LEFT_PX, SIZE_PX - 8);
    const y = this.axis(limitsOf("mm", least(tips), most(tips)), SIZE_PX - BELOW_PX, 8);
    this.frame(ctx, x, y);
    ctx.save();
    ctx.beginPath();
    ctx.rect(LEFT_PX, 8, SIZE_PX - 8 - LEFT_PX, SIZE_PX - BELOW_PX - 8);
    ctx.clip();
    this.trace(ctx, all, [x, y], 0.1, 0.35);
    this.trace(ctx, points, [x, y], 0.25, 1);
    const [head, wanted] = points[points.length - 1];
    ctx.globalAlpha = 1;
    ctx.fillStyle = this.now.tip;
    ctx.beginPath();
    ctx.arc(x.of(head), y.of(wanted), 5, 0, 2 * Math.PI);
    ctx.fill();
    ctx.restore();
  }

  /** What is possible as a band, what is wanted as a line; no stronger than this. */
  trace(ctx, points, [x, y], band, line) {
    ctx.lineWidth = 1;
    ctx.strokeStyle = this.now.phase;
    ctx.globalAlpha = band;
    ctx.beginPath();
    for (const [head, , high, low] of points) {
      ctx.moveTo(x.of(head), y.of(low));
      ctx.lineTo(x.of(head), y.of(high));
    }
    ctx.stroke();
    ctx.globalAlpha = line;
    ctx.lineWidth = 2;
    ctx.strokeStyle = this.now.tip;
    ctx.beginPath();
    points.forEach(([head, wanted], i) => ctx[i ? "lineTo" : "moveTo"](x.of(head), y.of(wanted)));
    ctx.stroke();
  }

  axis([from, to], begin, end) {
    return { from, to, of: (value) => begin + ((value - from) / (to - from)) * (end - begin) };
  }

  frame(ctx, x, y) {
    ctx.strokeStyle = this.now.grid;
    ctx.fillStyle = this.now.ink;
    ctx.lineWidth = 1;
    ctx.font = "12px system-ui, sans-serif";
    ctx.strokeRect(LEFT_PX, 8, SIZE_PX - 8 - LEFT_PX, SIZE_PX - BELOW_PX - 8);
    const put = (words, left, top, align) => {
      ctx.textAlign = align;
      ctx.fillText(words, left, top);
    };
    const show = (value) => String(Number(value.toPrecision(6))).replace("-", "−");
    put(show(x.from), LEFT_PX, SIZE_PX - 22, "left");
    put(show(x.to), SIZE_PX - 8, SIZE_PX - 22, "right");
    put(text.signals.loop.head, (LEFT_PX + SIZE_PX) / 2, SIZE_PX - 5, "center");
    put(show(y.from), LEFT_PX - 5, SIZE_PX - BELOW_PX, "right");
    put(show(y.to), LEFT_PX - 5, 18, "right");
    ctx.save();
    ctx.translate(14, (SIZE_PX - BELOW_PX) / 2);
    ctx.rotate(-Math.PI / 2);
    put(text.signals.loop.tip, 0, 0, "center");
    ctx.restore();
  }

  repaint() {
    this.now = undefined;
  }
}

function least(values) {
  return values.reduce((one, other) => Math.min(one, other), Infinity);
}

function most(values) {
  return values.reduce((one, other) => Math.max(one, other), -Infinity);
}
