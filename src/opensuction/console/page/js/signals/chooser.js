// Which channels are drawn: those with a title first, every column of the machine behind them.

import { make, mark, say, show } from "../dom.js";
import { fill, text } from "../text.js";

export const MOST = 12; // of the 16 that may be asked for: the loop has some of its own

export class Chooser {
  /** groups of `GET /signals/channels`; onchange(names) once they are taken. */
  constructor(channels, onchange) {
    this.channels = channels;
    this.onchange = onchange;
    this.chosen = new Set();
    const words = text.signals.chooser;
    this.search = make("input", { type: "search", id: "signals-search", autocomplete: "off", oninput: () => this.filter() });
    this.count = make("p", { class: "chooser-count", role: "status" });
    this.take = make("button", { type: "button", class: "primary", onclick: () => this.done() }, words.take);
    this.list = make("div", { class: "chooser-list" });
    this.boxes = new Map();
    for (const group of new Set(channels.map((one) => one.group))) this.list.append(this.groupOf(group));
    this.element = make("section", { class: "chooser", "aria-label": words.title, hidden: true, onkeydown: (event) => this.key(event) },
      make("div", { class: "chooser-head" }, make("h2", {}, words.title), this.count, this.take,
        make("button", { type: "button", onclick: () => this.close() }, text.shell.cancel)),
      make("label", { class: "field-label", for: "signals-search" }, words.search), this.search, this.list);
  }

  groupOf(group) {
    const rows = this.channels.filter((one) => one.group === group).map((one) => this.rowOf(one));
    const isRaw = rows.length > 20;
    return make("details", { class: "chooser-group", open: !isRaw, "data-group": group },
      make("summary", {}, fill(text.signals.chooser.group, { group, count: rows.length })), make("div", { class: "chooser-rows" }, ...rows));
  }

  rowOf(channel) {
    const box = make("input", { type: "checkbox", onchange: () => this.toggle(channel.name, box.checked) });
    const origin = text.signals.origins[channel.origin] ?? channel.origin;
    const row = make("label", { class: "chooser-row" }, box,
      make("span", {}, make("span", { class: "chooser-title" }, channel.title), make("span", { class: "chooser-name" },
        [origin, channel.unit, channel.title === channel.name ? "" : channel.name, channel.is_exact ? "" : text.signals.chooser.coarse].filter(Boolean).join(" · "))));
    this.boxes.set(channel.name, { box, row, words: `${channel.title} ${channel.name} ${channel.unit}`.toLowerCase() });
    return row;
  }

  open(names) {
    this.chosen = new Set(names);
    for (const [name, { box }] of this.boxes) box.checked = this.chosen.has(name);
    this.search.value = "";
    this.filter();
    this.tell();
    show(this.element, true);
    this.search.focus();
  }

  toggle(name, isOn) {
    if (isOn) this.chosen.add(name);
    else this.chosen.delete(name);
    this.tell();
  }

  tell() {
    const count = this.chosen.size;
    const words = text.signals.chooser;
    say(this.count, count > MOST ? fill(words.tooMany, { most: MOST, count }) : fill(words.count, { most: MOST, count }));
    this.take.disabled = count === 0 || count > MOST;
    mark(this.count, "data-bad", this.take.disabled);
  }

  filter() {
    const wanted = this.search.value.trim().toLowerCase();
    for (const { row, words } of this.boxes.values()) show(row, words.includes(wanted));
    for (const group of this.list.children) {
      const any = [...group.querySelectorAll(".chooser-row")].some((row) => !row.hidden);
      show(group, any);
      if (wanted) group.open = any;
    }
  }

  key(event) {
    if (event.key === "Escape") {
      event.stopPropagation();
      this.close();
    }
  }

  done() {
    this.onchange(this.channels.map((one) => one.name).filter((name) => this.chosen.has(name)));
    this.close();
  }

  close() {
    show(this.element, false);
    this.onclose?.();
  }
}
