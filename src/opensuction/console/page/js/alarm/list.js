// All alarms that are shown now, in a panel under the bar: what is wrong, what to do, what was done.

import { make, mark, show } from "../dom.js";
import { GOOD } from "../live.js";
import { text } from "../text.js";
import { capital } from "../words.js";

export class AlarmList {
  constructor() {
    this.rows = make("ol", { class: "alarm-rows" });
    this.element = make("section", { class: "alarm-list", "aria-label": text.alarm.all, hidden: true }, this.rows);
    this.shown = "";
  }

  get isOpen() {
    return !this.element.hidden;
  }

  toggle(button) {
    show(this.element, !this.isOpen);
    mark(button, "aria-expanded", String(this.isOpen));
  }

  update(state, link) {
    const alarms = link.kind === GOOD ? state.alarms : [];
    if (alarms.length < 2) show(this.element, false);
    const seen = JSON.stringify(alarms);
    if (seen === this.shown) return;
    this.shown = seen;
    this.rows.replaceChildren(...alarms.map(row));
  }
}

function row(alarm) {
  const words = text.alarm;
  const notes = [alarm.present ? words.present : words.over];
  if (alarm.acknowledged) notes.push(words.acknowledged);
  if (alarm.escalated) notes.push(words.escalated);
  const item = make(
    "li",
    { "data-priority": alarm.priority },
    make("span", { class: "alarm-row-priority" }, words.priorities[alarm.priority]),
    make("div", {},
      make("p", { class: "alarm-row-sentence" }, capital(alarm.sentence)),
      make("p", {}, alarm.remedy),
      make("p", { class: "alarm-row-notes" }, notes.join(" · "))),
  );
  return item;
}
