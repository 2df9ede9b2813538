// What happened, as a list: each leads to its instant.

import { capital } from "../words.js";
import { make } from "../dom.js";
import { fill, text } from "../text.js";
import { timeOfDay } from "./scale.js";

const SHOWN = 40;

/** One mark in words. */
export function wordsOf(one) {
  const words = text.signals.marks;
  const name = capital(one.sentence || one.name.replaceAll("-", " ").replaceAll("_", " "));
  if (one.what === "phase") return text.signals.phases[one.name] ?? name;
  if (one.what === "alarm") return fill(one.detail === "ended" ? words.over : words.raised, { name });
  if (one.what === "source") return words.source;
  return fill(words[one.what] ?? words.other, { name, detail: one.detail }).trim();
}

export class Happened {
  constructor(marks, offset, onchoose) {
    this.marks = marks;
    this.offset = offset;
    this.onchoose = onchoose;
    this.changes = -1;
    this.list = make("ol", { class: "happened-list" });
    this.none = make("p", { class: "happened-none" }, text.signals.noEvents);
    this.element = make("section", { class: "happened", "aria-label": text.signals.events }, make("h2", {}, text.signals.events), this.none, this.list);
  }

  /** The newest first, only where there is another. */
  update() {
    if (this.marks.changes === this.changes) return;
    this.changes = this.marks.changes;
    const newest = this.marks.all.slice(-SHOWN).reverse();
    this.none.hidden = newest.length > 0;
    this.list.replaceChildren(...newest.map((one) => make("li", {},
      make("button", { type: "button", class: "happened-one", "data-what": one.what, onclick: () => this.onchoose(one) },
        make("span", { class: "happened-time" }, timeOfDay(one.time_s, this.offset(), 1)), make("span", {}, wordsOf(one))))));
  }
}
