// The vacuum: a gauge with set point and limit, and the figure beneath.

import { draw, make, mark, say } from "../dom.js";
import { fill, text } from "../text.js";
import { number } from "../words.js";

const CENTRE = [100, 96];
const RADIUS = 80;
const ARC = `M ${CENTRE[0] - RADIUS},${CENTRE[1]} A ${RADIUS},${RADIUS} 0 0 1 ${CENTRE[0] + RADIUS},${CENTRE[1]}`;
const BEYOND = 1.25; // the scale ends beyond the limit by a quarter
const NO_LIMIT_MMHG = 200;

function point(share, radius) {
  const angle = Math.PI * (1 - share);
  return [CENTRE[0] + radius * Math.cos(angle), CENTRE[1] - radius * Math.sin(angle)].map((one) => one.toFixed(1));
}

function tick(share, from, to) {
  return `M ${point(share, from)} L ${point(share, to)}`;
}

export class Gauge {
  constructor() {
    const words = text.bedside.vacuum;
    this.value = draw("path", { class: "gauge-value", d: ARC, pathLength: 1, "stroke-dasharray": "0 2" });
    this.over = draw("path", { class: "gauge-over", d: ARC, pathLength: 1, "stroke-dasharray": "0 2" });
    this.setpoint = draw("path", { class: "gauge-setpoint", d: "" });
    this.limit = draw("path", { class: "gauge-limit", d: "" });
    this.svg = draw("svg", { viewBox: "0 0 200 104", class: "gauge", role: "img" },
      draw("path", { class: "gauge-back", d: ARC }), this.over, this.value, this.setpoint, this.limit);
    this.figure = make("span", { class: "big" }, "–");
    this.marks = make("p", { class: "tile-note" });
    this.pump = make("p", { class: "tile-note" });
    this.element = make("section", { class: "tile vacuum", "aria-label": words.title },
      make("h2", {}, words.title), this.svg,
      make("p", { class: "gauge-figure" }, this.figure, make("span", { class: "unit" }, "mmHg")), this.marks, this.pump);
  }

  update(state, machine) {
    const words = text.bedside.vacuum;
    const unknown = text.bedside.unknown;
    const limit = machine?.limits?.vacuum_mmhg ?? null;
    const most = (limit ?? NO_LIMIT_MMHG) * BEYOND;
    const share = (value) => Math.min(Math.max(value / most, 0), 1);
    const vacuum = state.vacuum_mmhg;
    const set = state.vacuum_setpoint_mmhg;
    mark(this.value, "stroke-dasharray", `${(vacuum === null ? 0 : share(vacuum)).toFixed(3)} 2`);
    mark(this.over, "stroke-dasharray", limit === null ? "0 2" : `0 ${share(limit).toFixed(3)} 1 0`);
    mark(this.limit, "d", limit === null ? "" : tick(share(limit), RADIUS - 13, RADIUS + 15));
    mark(this.setpoint, "d", set > 0 ? tick(share(set), RADIUS - 20, RADIUS - 2) : "");
    mark(this.element, "data-out", limit !== null && vacuum !== null && vacuum > limit);
    mark(this.element, "data-on", state.valve_open === true);
    say(this.figure, vacuum === null ? "–" : number(Math.max(vacuum, 0)));
    const told = [set === null ? null : fill(words.setpoint, { mmhg: number(set) }), limit === null ? null : fill(words.limit, { mmhg: number(limit) })];
    say(this.marks, told.filter(Boolean).join(" · "));
    say(this.pump, vacuum === null ? text.bedside.notMeasured : state.pump_on === null ? unknown : words.pump[state.pump_on]);
    mark(this.svg, "aria-label", fill(words.describe, { mmhg: vacuum === null ? unknown : number(vacuum), set: set === null ? unknown : number(set), limit: limit === null ? unknown : number(limit) }));
  }
}
