// Trends over days: what was done, and what it came to.

import { machineNow } from "../clock.js";
import { make } from "../dom.js";
import { field } from "../dialog.js";
import { fill, text } from "../text.js";
import { number } from "../words.js";
import { load, table } from "./parts.js";
import { drawOutcomes, drawQuantity, keepDrawn } from "./trend_plot.js";

const DAYS = [7, 30, 90, 365];
const USUAL = "30";
const AGAIN_MS = 3000;

/** Where a range of days begins, by the machine's clock and this device's time zone. */
function since(days) {
  const now = new Date(machineNow() ?? Date.now());
  return new Date(now.getFullYear(), now.getMonth(), now.getDate() + 1 - days);
}

class Trends {
  constructor(root, api) {
    this.api = api;
    const words = text.history.trends;
    this.range = field("days", words.range, { options: DAYS.map((days) => [String(days), fill(words.last, { days })]) });
    this.range.input.value = USUAL;
    this.range.input.addEventListener("change", () => this.begin());
    this.body = make("div", { class: "trend-body" });
    this.isWanted = true;
    this.stop = () => {};
    this.undraw = () => {};
    root.replaceChildren(make("section", { class: "trends" }, make("div", { class: "history-filters" }, this.range.element), this.body));
    this.begin();
  }

  /** ask: with a person's request (get), or again by itself (watch). */
  ask(ask = "get") {
    const query = new URLSearchParams({ from: since(Number(this.range.input.value)).toISOString(), ahead_min: String(-new Date().getTimezoneOffset()) });
    return this.api[ask](`/trends?${query}`);
  }

  begin() {
    this.close();
    this.isWanted = true;
    this.stop = load(this.body, () => this.ask(), (found) => this.show(found));
  }

  close() {
    this.isWanted = false;
    clearTimeout(this.timer);
    this.stop();
    this.undraw();
  }

  async look() {
    try {
      const found = await this.ask("watch");
      if (this.isWanted) this.show(found);
    } catch {
      if (this.isWanted) this.timer = setTimeout(() => this.look(), 3 * AGAIN_MS);
    }
  }

  show(found) {
    const words = text.history.trends;
    this.undraw();
    clearTimeout(this.timer);
    if (found.pending) this.timer = setTimeout(() => this.look(), AGAIN_MS);
    if (!found.days.length) {
      this.body.replaceChildren(make("p", { class: "history-note", role: "status" }, words.none));
      return;
    }
    const notes = [];
    if (found.pending) notes.push(fill(words.pending, found));
    if (found.without_recording) notes.push(fill(words.without, { n: found.without_recording, cycles: found.cycles }));
    if (found.cut) notes.push(words.cut);
    const known = Object.keys(words.quantities).filter((name) => found.days.some((day) => day.quantities[name]));
    const unknown = Object.keys(words.quantities).filter((name) => !known.includes(name));
    const plots = ["outcomes", ...known].map((name) => [name, make("div", { class: "trend-plot" })]);
    const figures = plots.map(([name, place]) => make("figure", { class: "trend" }, make("h2", {}, titleOf(name)), place));
    if (unknown.length && !found.pending) notes.push(fill(words.unknown, { names: unknown.map((name) => words.quantities[name][0].toLowerCase()).join(", ") }));
    this.body.replaceChildren(...notes.map((note) => make("p", { class: "trend-note", role: "status" }, note)),
      make("p", { class: "trend-note" }, words.each), make("div", { class: "trend-grid" }, figures), tabled(found, known));
    this.undraw = keepDrawn(this.body, () => plots.map(([name, place]) => (name === "outcomes" ? drawOutcomes(place, found.days) : drawQuantity(place, found.days, name))));
  }
}

function titleOf(name) {
  const words = text.history.trends;
  if (name === "outcomes") return words.outcomes;
  const [title, unit] = words.quantities[name];
  return unit ? `${title} (${unit})` : title;
}

/** The same in words, for those who do not see the plots. */
function tabled(found, known) {
  const words = text.history.trends;
  const outcomes = Object.entries(text.history.outcomes);
  const heads = [words.day, ...outcomes.map(([, label]) => label), ...known.map(titleOf)];
  const rows = found.days.map((day) => [day.day, ...outcomes.map(([name]) => String(day.outcomes[name] ?? 0)), ...known.map((name) => spread(day.quantities[name], words.quantities[name][2]))]);
  return make("details", { class: "trend-table" }, make("summary", {}, words.table), table(words.table, heads, rows).element);
}

function spread(one, decimals) {
  if (!one) return "\u2013";
  const { median, lowest, highest } = one;
  const values = { median: number(median, decimals), lowest: number(lowest, decimals), highest: number(highest, decimals) };
  return values.lowest === values.highest ? values.median : fill(text.history.trends.values, values);
}

export function mountTrends(root, context) {
  const trends = new Trends(root, context.api);
  return () => trends.close();
}
