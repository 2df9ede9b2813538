// Tiles of the bedside view: tip, valve, monitor, passes, last cycle.

import { machineNow } from "../clock.js";
import { draw, make, mark, say } from "../dom.js";
import { isLeftInside, isResting } from "../situation.js";
import { fill, text } from "../text.js";
import { capital, clock, countdown, number } from "../words.js";

/** A tile with a title, a figure with its unit, and lines beneath. */
function tile(name, title, unit = "", lines = 1) {
  const figure = make("span", { class: "figure" }, "–");
  const notes = Array.from({ length: lines }, () => make("p", { class: "tile-note" }));
  const element = make("section", { class: `tile ${name}`, "aria-label": title },
    make("h2", {}, title),
    make("p", { class: "tile-figure" }, figure, unit ? make("span", { class: "unit" }, unit) : null),
    notes);
  return { element, figure, notes };
}

export class Tip {
  constructor() {
    this.tile = tile("tip", text.bedside.tip.title, "mm", 3);
    this.tile.figure.classList.add("big");
    this.unit = this.tile.element.querySelector(".unit");
    this.element = this.tile.element;
  }

  update(state) {
    const words = text.bedside.tip;
    const { figure, notes } = this.tile;
    const isOut = state.is_inside === false;
    const isKnown = state.tip_mm !== null;
    say(figure, isOut ? words.out : isKnown ? number(state.tip_mm) : "–");
    this.unit.hidden = isOut;
    const side = isKnown && state.tip_mm < 0 ? words.above : words.below;
    say(notes[0], isLeftInside(state) ? words.left : isOut ? words.outDetail : isKnown ? side : text.bedside.unknown);
    const half_mm = (state.tip_high_mm - state.tip_low_mm) / 2;
    const ways = { in: words.in, out: words.outward, still: words.still };
    const range = isKnown && state.tip_high_mm !== null ? fill(words.range, { mm: number(half_mm, 1) }) : null;
    say(notes[1], isOut ? "" : [range, ways[state.moving]].filter(Boolean).join(" · "));
    const contact = state.contact ? (isOut ? words.contactOutside : words.contact) : "";
    say(notes[2], contact || (isLeftInside(state) || state.target_mm === null ? "" : fill(words.target, { mm: number(state.target_mm) })));
    mark(notes[2], "data-told", contact !== "");
    mark(this.element, "data-inside", state.is_inside !== false);
    mark(this.element, "data-left", isLeftInside(state));
  }
}

export class Valve {
  constructor() {
    const words = text.bedside.valve;
    this.cam = draw("g", {}, draw("circle", { class: "cam", cx: 0, cy: 0, r: 17 }), draw("path", { class: "cam-lobe", d: "M -9,-14 Q 0,-34 9,-14 z" }), draw("circle", { class: "cam-axis", cx: 0, cy: 0, r: 4 }));
    this.slide = draw("rect", { class: "valve-slide", x: 70, y: 6, width: 13, height: 52, rx: 2 });
    const svg = draw("svg", { viewBox: "0 0 150 64", class: "valve-drawing", "aria-hidden": "true" },
      draw("path", { class: "valve-line", d: "M 48,40 H 150" }), this.slide, draw("g", { transform: "translate(26,36)" }, this.cam));
    this.word = make("span", { class: "figure" }, "–");
    this.note = make("p", { class: "tile-note" });
    this.element = make("section", { class: "tile valve", "aria-label": words.title }, make("h2", {}, words.title), svg, make("p", { class: "tile-figure" }, this.word), this.note);
  }

  update(state) {
    const words = text.bedside.valve;
    const isOpen = state.valve_open;
    say(this.word, isOpen === null ? "–" : isOpen ? words.open : words.closed);
    mark(this.element, "data-open", isOpen === true);
    mark(this.slide, "transform", isOpen ? "translate(0,-26)" : null);
    const cam = state.cam_rad;
    mark(this.cam, "transform", cam === null ? null : `rotate(${((cam * 180) / Math.PI).toFixed(0)})`);
    say(this.note, cam === null ? words.camUnknown : fill(words.cam, { deg: number((cam * 180) / Math.PI) }));
  }
}

const MONITOR = [
  ["spo2_percent", "spo2", "%", 0],
  ["heart_rate_per_min", "heart", "/min", 0],
  ["airway_pressure_cmh2o", "pressure", "cmH₂O", 0],
];

export class Monitor {
  constructor() {
    const words = text.bedside.monitor;
    this.tiles = MONITOR.map(([name, title, unit, decimals]) => ({ name, decimals, ...tile("vital", words[title], unit, 1) }));
    this.elements = this.tiles.map((one) => one.element);
  }

  update(state, machine) {
    const words = text.bedside.monitor;
    for (const one of this.tiles) {
      const value = state.monitor[one.name];
      const isMeasured = value !== null && value !== undefined;
      say(one.figure, isMeasured ? number(value, one.decimals) : "–");
      const [low, high] = limitsOf(machine?.limits?.[one.name]);
      const isOut = isMeasured && ((low !== null && value < low) || (high !== null && value > high));
      const limits = limitWords(low, high);
      const missing = state.monitor.connected ? text.bedside.notMeasured : text.bedside.notConnected;
      say(one.notes[0], isMeasured ? (isOut ? `${words.out} · ${limits}` : limits) : missing);
      mark(one.element, "data-out", isOut);
      mark(one.element, "data-missing", !isMeasured);
    }
  }
}

/** A limit as the machine tells it: the least value, or [least, most]. */
function limitsOf(told) {
  if (told === null || told === undefined) return [null, null];
  return Array.isArray(told) ? told : [told, null];
}

function limitWords(low, high) {
  const words = text.bedside.monitor;
  if (low !== null && high !== null) return fill(words.range, { low: number(low), high: number(high) });
  if (low !== null) return fill(words.least, { limit: `\u2265 ${number(low)}` });
  if (high !== null) return fill(words.least, { limit: `\u2264 ${number(high)}` });
  return words.noLimit;
}

export class Rest {
  constructor() {
    const words = text.bedside;
    this.passes = tile("passes", words.passes.title, "", 1);
    this.rest = tile("rest", words.passes.rest, "", 1);
    this.next = tile("next", words.passes.next, "", 1);
    this.last = tile("last", words.last.title, "", 1);
    this.elements = [this.passes, this.rest, this.next, this.last].map((one) => one.element);
  }

  update(state, machine) {
    const words = text.bedside.passes;
    const left = state.passes_most ? Math.max(state.passes_most - state.passes, 0) : null;
    say(this.passes.figure, left === null ? "–" : String(left));
    say(this.passes.notes[0], left === null ? text.bedside.unknown : fill(words.of, { most: state.passes_most }));
    mark(this.passes.element, "data-out", left === 0);
    say(this.rest.figure, state.rest_left_s > 0 ? countdown(state.rest_left_s) : words.ready);
    say(this.rest.notes[0], state.rest_left_s > 0 ? (isResting(state) ? words.wait : words.after) : "");
    this.updateNext(machine?.next_cycle_at ?? null);
    this.updateLast(state.last_cycle);
  }

  updateNext(at) {
    const words = text.bedside.passes;
    const { figure, notes } = this.next;
    say(figure, at === null ? "–" : clock(at));
    const left_s = at === null ? null : (Date.parse(at) - (machineNow() ?? Date.now())) / 1000;
    const when = left_s === null ? words.nextNone : left_s > 0 ? fill(words.nextIn, { left: countdown(left_s) }) : words.nextDue;
    say(notes[0], when);
  }

  updateLast(last) {
    const words = text.bedside.last;
    const { figure, notes, element } = this.last;
    say(figure, last ? words[last.outcome ?? "running"] || capital(last.outcome) : words.none);
    say(notes[0], last ? [last.why, last.ended_at ? fill(words.at, { time: clock(last.ended_at) }) : ""].filter(Boolean).join(" · ") : "");
    mark(element, "data-outcome", last ? last.outcome : null);
  }
}
