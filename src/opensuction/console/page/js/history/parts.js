// What the parts of the history share: loading, refusals, marks, tables, times.

import { make } from "../dom.js";
import { text } from "../text.js";

/** Fill an element by what comes; while it does it says so, and what is refused can be tried again.

    Gives what makes the answer count no more. */
export function load(root, ask, show) {
  let isWanted = true;
  const begin = async () => {
    root.replaceChildren(make("p", { class: "history-note", role: "status" }, text.history.loading));
    try {
      const found = await ask();
      if (isWanted) show(found);
    } catch (error) {
      if (isWanted) root.replaceChildren(refusal(error, begin));
    }
  };
  begin();
  return () => { isWanted = false; };
}

/** What was refused, with a button to try again. */
export function refusal(error, again) {
  return make("div", { class: "history-refused", role: "alert" }, make("p", {}, error.detail || String(error)),
    make("button", { type: "button", onclick: again }, text.history.again));
}

/** The outcome of a cycle, in a word with a mark: never by colour alone. */
export function outcome(cycle) {
  const name = cycle.outcome ?? "running";
  return make("span", { class: `outcome ${name}` }, make("span", { "aria-hidden": "true" }, text.history.marks[name]), ` ${text.history.outcomes[name]}`);
}

/** The priority of an alarm, likewise. */
export function priority(alarm) {
  return make("span", { class: `priority ${alarm.priority}` }, text.history.priorities[alarm.priority] ?? alarm.priority);
}

/** A table that scrolls by itself. rows: lists of cells; the first heads its row. */
export function table(label, heads, rows) {
  const body = make("tbody", {}, rows.map(row));
  const element = make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": label },
    make("table", {}, make("thead", {}, make("tr", {}, heads.map((head) => make("th", { scope: "col" }, head)))), body));
  return { element, body };
}

/** A row of such a table. */
export function row(cells) {
  return make("tr", {}, cells.map((cell, i) => make(i === 0 ? "th" : "td", i === 0 ? { scope: "row" } : {}, cell ?? "")));
}

/** Date and time to the second: what is on record is told exactly. */
export function instant(iso) {
  return new Date(iso).toLocaleString([], { year: "numeric", month: "short", day: "numeric", hour: "2-digit", minute: "2-digit", second: "2-digit", hour12: false });
}

/** Bytes as people read them. */
export function bytes(size) {
  return size < 1e6 ? `${Math.max(Math.round(size / 1e3), 1)} kB` : `${(size / 1e6).toFixed(1)} MB`;
}

/** The address of a cycle's page. */
export const cycleAddress = (id) => `#/history/cycle/${encodeURIComponent(id)}`;
