// A plot of the channels of one unit over time.

import uPlot from "../../vendor/uPlot.js";
import { make, mark, say } from "../dom.js";
import { text } from "../text.js";
import { decimate } from "./decimate.js";
import { instantsOf, limitsOf, valueOf } from "./scale.js";

export const LEFT_PX = 62;
const LINES = 8; // colours

/** How much larger than usual the page's letters are: on large screens they are. */
export function enlarged() {
  return parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
}

/** Letters of a canvas, like those beside it. */
export function letters(px, weight = 400) {
  return `${weight} ${Math.round(px * enlarged())}px system-ui, sans-serif`;
}

/** Colours as the theme has them now. */
export function colours() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => style.getPropertyValue(name).trim();
  return {
    lines: Array.from({ length: LINES }, (_, i) => of(`--signal-${i + 1}`)),
    ink: of("--soft"), grid: of("--line"), phase: of("--edge"), alarm: of("--bad"), tip: of("--tip"),
  };
}

export class Strip {
  /** lines: [{place, channel, colour}], place: of the channel in the buffer. */
  constructor(unit, lines, options) {
    this.unit = unit;
    this.lines = lines;
    this.options = options; // {height, offset(), marks()}
    this.limits = [0, 1];
    this.plotted = make("div", { class: "strip-plot", "aria-hidden": "true" });
    this.legend = make("div", { class: "strip-legend" });
    this.element = make("section", { class: "strip", "aria-label": unit || text.signals.noUnit }, this.plotted, this.legend);
    this.rows = lines.map((line) => this.legendOf(line));
    this.legend.append(make("p", { class: "strip-unit" }, unit || text.signals.noUnit), ...this.rows.map((row) => row.element));
  }

  legendOf({ channel, colour }) {
    const swatch = make("span", { class: `swatch swatch-${colour + 1}`, "aria-hidden": "true" });
    const value = make("output", { class: "line-value" }, "–");
    const cursors = make("span", { class: "line-cursors" });
    const title = make("span", { class: "line-title", title: channel.name }, channel.title);
    const origin = make("span", { class: "line-origin" }, text.signals.origins[channel.origin] ?? channel.origin);
    const element = make("div", { class: "line" }, swatch, make("span", { class: "line-what" }, title, " ", origin), value, cursors);
    return { element, value, cursors };
  }

  /** Draw anew from nothing: another size, other colours. */
  build(width) {
    this.plot?.destroy();
    const now = colours();
    const { height, offset } = this.options;
    const axis = { stroke: now.ink, grid: { stroke: now.grid, width: 1 }, ticks: { show: false }, font: letters(12) };
    this.plot = new uPlot({
      width,
      height,
      padding: [9, 8, 9, 0],
      cursor: { show: false },
      legend: { show: false },
      select: { show: false },
      scales: { x: { time: false, auto: false, range: (u, from, to) => [from, to] }, y: { range: () => this.limits } },
      axes: [
        { ...axis, size: 0, values: (u, marks) => marks.map(() => ""),
          splits: (u, place, from, to) => instantsOf(from, to, u.bbox.width / uPlot.pxRatio, offset()) },
        { ...axis, size: LEFT_PX * enlarged(), space: 26, values: (u, marks) => marks.map((one) => String(Number(one.toPrecision(6))).replace("-", "−")) },
      ],
      series: [{}, ...this.lines.map(({ colour }) => ({ stroke: now.lines[colour], width: 1.5, points: { show: false }, spanGaps: false }))],
      hooks: { drawClear: [(u) => this.mark(u, now)] },
    }, [[], ...this.lines.map(() => [])], this.plotted);
  }

  get box() {
    const ratio = uPlot.pxRatio;
    const { left, width } = this.plot.bbox;
    return { left: left / ratio, width: width / ratio };
  }

  /** Lines where phases begin and alarms are raised, behind the curves. */
  mark(u, now) {
    const { ctx, bbox } = u;
    ctx.save();
    for (const one of this.options.marks()) {
      const x = Math.round(u.valToPos(one.time_s, "x", true)) + 0.5;
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      const isAlarm = one.what === "alarm" || one.what === "trip";
      ctx.strokeStyle = isAlarm || one.what === "source" ? now.alarm : now.phase;
      ctx.setLineDash(isAlarm ? [] : [4 * uPlot.pxRatio, 4 * uPlot.pxRatio]);
      ctx.lineWidth = (isAlarm ? 2 : 1) * uPlot.pxRatio;
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
    }
    ctx.restore();
  }

  draw(buffer, from_s, to_s) {
    const { plot } = this;
    const points = decimate(buffer, this.lines.map((line) => line.place), from_s, to_s, Math.max(this.box.width, 100));
    let least = Infinity;
    let most = -Infinity;
    for (let i = 1; i < points.length; i += 1) {
      for (const value of points[i]) {
        if (value === null) continue;
        if (value < least) least = value;
        if (value > most) most = value;
      }
    }
    this.limits = limitsOf(this.unit, least, most);
    plot.batch(() => {
      plot.setData(points, false);
      plot.setScale("x", { min: from_s, max: to_s });
    });
  }

  /** Values as words: now, or at the cursors with their difference. */
  tell(buffer, row, cursors) {
    this.lines.forEach(({ place }, i) => {
      const words = (at) => (at === null ? "–" : valueOf(buffer.value(place, at), this.unit));
      say(this.rows[i].value, words(row));
      const both = cursors.a !== null && cursors.b !== null;
      const parts = [];
      if (cursors.a !== null) parts.push(`A ${words(cursors.a)}`);
      if (cursors.b !== null) parts.push(`B ${words(cursors.b)}`);
      if (both) parts.push(`B − A ${valueOf(buffer.value(place, cursors.b) - buffer.value(place, cursors.a), this.unit)}`);
      say(this.rows[i].cursors, parts.join("   "));
      mark(this.rows[i].cursors, "hidden", !parts.length);
    });
  }

  close() {
    this.plot?.destroy();
  }
}
