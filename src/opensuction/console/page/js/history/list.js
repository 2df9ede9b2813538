// A list that is narrowed by a form and goes on page by page.

import { make } from "../dom.js";
import { field } from "../dialog.js";
import { text } from "../text.js";
import { refusal, row, table } from "./parts.js";

/** The beginning of a day by this device's clock, some days later, as the interface takes it. */
function startOf(day, later = 0) {
  const [year, month, date] = day.split("-").map(Number);
  return new Date(year, month - 1, date + later).toISOString();
}

const remembered = new Map(); // what somebody narrowed a list to: it is still so on the way back

export class List {
  /** what: {path, key (of the answer), heads, cells(one), choices: {name: [[value, words]]}, words
      (hint of the search), none, noneSuch, label}. */
  constructor(context, what) {
    this.api = context.api;
    this.what = what;
    this.memory = `${context.session.name} ${what.path}`;
    this.asked = 0;
    this.build();
    for (const [name, value] of Object.entries(remembered.get(this.memory) ?? {})) this.fields[name].input.value = value;
    this.show();
  }

  build() {
    const words = text.history.filters;
    const { choices = {} } = this.what;
    this.fields = Object.fromEntries(Object.entries(choices).map(([name, options]) =>
      [name, field(name, words[name], { options: [["", words.any], ...options] })]));
    this.fields.from = field("from", words.from, { type: "date" });
    this.fields.to = field("to", words.to, { type: "date" });
    this.fields.text = field("text", words.text, { type: "search", maxlength: 100, placeholder: this.what.words, autocomplete: "off" });
    const submit = make("button", { type: "submit", class: "primary" }, words.submit);
    this.clear = make("button", { type: "button", onclick: () => this.reset() }, words.clear);
    this.form = make("form", { class: "history-filters", role: "search", "aria-label": words.label, novalidate: true },
      Object.values(this.fields).map((one) => one.element), make("div", { class: "row" }, submit, this.clear));
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.show();
    });
    for (const name of [...Object.keys(choices), "from", "to"]) this.fields[name].input.addEventListener("change", () => this.show());
    this.rows = make("div", { class: "history-rows" });
    this.element = make("div", { class: "history-list" }, this.form, this.rows);
  }

  reset() {
    for (const one of Object.values(this.fields)) one.input.value = "";
    this.show();
  }

  /** What is asked for, as a query. */
  query(before) {
    const query = new URLSearchParams({ limit: "50" });
    for (const [name, { input }] of Object.entries(this.fields)) {
      const value = input.value.trim();
      if (!value) continue;
      if (name === "from") query.set(name, startOf(value));
      else if (name === "to") query.set(name, startOf(value, 1));
      else query.set(name, value);
    }
    this.isNarrowed = [...query.keys()].length > 1;
    remembered.set(this.memory, Object.fromEntries(Object.entries(this.fields).map(([name, { input }]) => [name, input.value])));
    if (before) query.set("before", before);
    return query;
  }

  async show() {
    this.asked += 1;
    const mine = this.asked;
    for (const one of Object.values(this.fields)) one.refuse("");
    this.rows.replaceChildren(make("p", { class: "history-note", role: "status" }, text.history.loading));
    try {
      const found = await this.api.get(`${this.what.path}?${this.query()}`);
      if (mine === this.asked) this.begin(found);
    } catch (error) {
      if (mine !== this.asked) return;
      for (const [name, one] of Object.entries(this.fields)) one.refuse(error.of?.(name) ?? "");
      this.rows.replaceChildren(refusal(error, () => this.show()));
    }
    this.clear.hidden = !this.isNarrowed;
  }

  begin(found) {
    const listed = found[this.what.key];
    if (!listed.length) {
      const words = this.isNarrowed ? this.what.noneSuch : this.what.none;
      this.rows.replaceChildren(make("p", { class: "history-note", role: "status" }, words));
      return;
    }
    const { element, body } = table(this.what.label, this.what.heads, listed.map(this.what.cells));
    this.body = body;
    this.more = make("div", { class: "history-more" });
    this.rows.replaceChildren(element, this.more);
    this.offer(found.next);
  }

  offer(next) {
    if (next === null) {
      this.more.replaceChildren(make("p", { class: "history-end" }, text.history.end));
      return;
    }
    this.more.replaceChildren(make("button", { type: "button", onclick: () => this.goOn(next) }, text.history.older));
  }

  async goOn(before) {
    const mine = this.asked;
    this.more.replaceChildren(make("p", { class: "history-end", role: "status" }, text.history.loading));
    try {
      const found = await this.api.get(`${this.what.path}?${this.query(before)}`);
      if (mine !== this.asked) return;
      const rows = found[this.what.key].map((one) => row(this.what.cells(one)));
      this.body.append(...rows);
      this.offer(found.next);
      (rows[0]?.querySelector("a") ?? this.more.querySelector("button"))?.focus();
    } catch (error) {
      if (mine === this.asked) this.more.replaceChildren(refusal(error, () => this.goOn(before)));
    }
  }
}
