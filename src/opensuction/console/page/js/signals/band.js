// Above the plots: which phase it was, and where something happened.

import { make } from "../dom.js";
import { text } from "../text.js";
import { instantsOf, timeOfDay } from "./scale.js";
import { colours, enlarged, letters } from "./strip.js";

const PHASE_PX = 26;
const TIMES_PX = 18;
const GLYPHS = { alarm: "▲", trip: "◆", request: "●", source: "✕" };

export class Band {
  constructor() {
    this.canvas = make("canvas", { class: "signals-band", "aria-hidden": "true" });
  }

  draw(marks, box, [from_s, to_s], offset_s) {
    const ratio = devicePixelRatio;
    const { canvas } = this;
    this.phase_px = Math.round(PHASE_PX * enlarged());
    this.height_px = this.phase_px + Math.round(TIMES_PX * enlarged());
    const width = Math.round((box.left + box.width) * ratio);
    if (canvas.width !== width || canvas.height !== this.height_px * ratio) {
      canvas.width = width;
      canvas.height = this.height_px * ratio;
      canvas.style.width = `${width / ratio}px`;
      canvas.style.height = `${this.height_px}px`;
    }
    this.now ??= colours();
    const ctx = canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, this.height_px);
    ctx.save();
    ctx.beginPath();
    ctx.rect(box.left, 0, box.width, this.height_px);
    ctx.clip();
    const placeOf = (time_s) => box.left + ((time_s - from_s) / (to_s - from_s)) * box.width;
    this.drawPhases(ctx, marks.phases(from_s, to_s), placeOf, box);
    for (const one of marks.between(from_s, to_s)) this.drawGlyph(ctx, one, placeOf(one.time_s));
    this.drawTimes(ctx, instantsOf(from_s, to_s, box.width, offset_s), placeOf, [offset_s, to_s - from_s]);
    ctx.restore();
  }

  drawTimes(ctx, instants, placeOf, [offset_s, span_s]) {
    ctx.font = letters(12);
    ctx.fillStyle = this.now.ink;
    ctx.textAlign = "center";
    for (const one of instants) ctx.fillText(timeOfDay(one, offset_s, span_s), placeOf(one), this.height_px - 7);
    ctx.textAlign = "left";
  }

  drawPhases(ctx, phases, placeOf, box) {
    ctx.font = letters(13, 600);
    ctx.textBaseline = "middle";
    phases.forEach(({ name, from_s, to_s }) => {
      const left = Math.max(placeOf(from_s), box.left);
      const right = Math.min(placeOf(to_s), box.left + box.width);
      ctx.fillStyle = this.now.grid;
      ctx.fillRect(left + 1, 2, right - left - 2, this.phase_px - 4);
      const words = text.signals.phases[name] ?? name;
      if (ctx.measureText(words).width > right - left - 22) return;
      ctx.fillStyle = this.now.ink;
      ctx.fillText(words, left + 14, this.phase_px / 2 + 1);
    });
  }

  drawGlyph(ctx, one, x) {
    const glyph = GLYPHS[one.what];
    if (glyph === undefined) return;
    ctx.font = letters(13);
    ctx.textAlign = "center";
    ctx.fillStyle = one.what === "request" ? this.now.tip : this.now.alarm;
    ctx.fillText(glyph, x, this.phase_px / 2);
    ctx.textAlign = "left";
  }

  /** Other colours from now on. */
  repaint() {
    this.now = undefined;
  }
}
