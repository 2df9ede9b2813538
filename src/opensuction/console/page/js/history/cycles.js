// All cycles of this machine.

import { make } from "../dom.js";
import { text } from "../text.js";
import { List } from "./list.js";
import { cycleAddress, instant, outcome } from "./parts.js";

const OUTCOMES = ["completed", "aborted", "interrupted"];

function cells(cycle) {
  const words = text.history.cycles;
  return [
    make("a", { href: cycleAddress(cycle.id), class: "history-open" }, String(cycle.number)),
    instant(cycle.started_at),
    outcome(cycle),
    cycle.patient ?? words.bench,
    cycle.protocol,
    cycle.requested_by,
    cycle.why,
  ];
}

export function mountCycles(root, context) {
  const words = text.history.cycles;
  const list = new List(context, {
    path: "/cycles",
    key: "cycles",
    label: text.history.tab.cycles,
    heads: [words.number, words.started, words.outcome, words.patient, words.protocol, words.asked, words.detail],
    cells,
    choices: { outcome: OUTCOMES.map((name) => [name, text.history.outcomes[name]]) },
    words: words.words,
    none: words.none,
    noneSuch: words.noneSuch,
  });
  root.replaceChildren(list.element);
  return () => {};
}
