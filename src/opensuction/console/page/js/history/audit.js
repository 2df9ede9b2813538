// Whether the records are whole, and what people did.

import { make } from "../dom.js";
import { field, form } from "../dialog.js";
import { fill, text } from "../text.js";
import { List } from "./list.js";
import { cycleAddress, instant, load } from "./parts.js";

const AGAIN_MS = 1000;

class Trail {
  constructor(api) {
    this.api = api;
    this.body = make("div", { class: "audit-body" });
    this.element = make("section", { class: "audit", "aria-labelledby": "audit-title" },
      make("h2", { id: "audit-title" }, text.history.audit.whole), make("p", {}, text.history.audit.say), this.body);
    this.isWanted = true;
    this.end = load(this.body, () => this.api.get("/audit"), (found) => this.show(found));
  }

  close() {
    this.isWanted = false;
    this.end();
    clearTimeout(this.timer);
  }

  show(found) {
    if (!this.isWanted) return;
    const words = text.history.audit;
    const parts = [make("p", {}, fill(words.entries, found)), make("code", { class: "audit-head" }, found.head)];
    if (found.state === "running") {
      parts.push(make("p", { role: "status" }, words.running));
      this.timer = setTimeout(() => this.look(), AGAIN_MS);
    } else {
      parts.push(verdict(found), this.ask());
    }
    this.body.replaceChildren(...parts);
  }

  async look() {
    try {
      this.show(await this.api.watch("/audit"));
    } catch {
      if (this.isWanted) this.timer = setTimeout(() => this.look(), 3 * AGAIN_MS);
    }
  }

  ask() {
    const words = text.history.audit;
    const expected = field("expected", words.expected, { maxlength: 64, autocomplete: "off", spellcheck: "false" }, words.expectedRule);
    const { element } = form({ expected }, words.begin, async (values) => {
      this.show(await this.api.query("/audit", { expected: values.expected.trim() || null }));
    });
    return element;
  }
}

function verdict(found) {
  const words = text.history.audit;
  if (found.failure) return make("p", { class: "verdict bad", role: "status" }, fill(words.failed, { detail: found.failure }));
  if (!found.verdict) return make("p", { hidden: true });
  const told = { ...found.verdict, when: instant(found.checked_at) };
  const isGood = found.verdict.is_whole;
  return make("p", { class: `verdict ${isGood ? "good" : "bad"}`, role: "status" }, `${isGood ? "\u2713" : "\u2715"} ${fill(isGood ? words.good : words.bad, told)}`);
}

export function mountAudit(root, context) {
  const words = text.history.audit;
  const trail = new Trail(context.api);
  const list = new List(context, {
    path: "/actions",
    key: "actions",
    label: words.actions,
    heads: [words.at, words.who, words.what, words.detail, words.cycle],
    cells: (action) => [
      instant(action.done_at),
      action.done_by,
      action.what,
      action.detail,
      action.cycle_id ? make("a", { href: cycleAddress(action.cycle_id), class: "history-open" }, text.history.alarms.open) : "",
    ],
    words: words.words,
    none: words.none,
    noneSuch: words.noneSuch,
  });
  root.replaceChildren(trail.element, make("h2", {}, words.actions), list.element);
  return () => trail.close();
}
