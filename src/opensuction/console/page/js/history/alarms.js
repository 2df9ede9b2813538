// The alarm log.

import { make } from "../dom.js";
import { text } from "../text.js";
import { capital } from "../words.js";
import { List } from "./list.js";
import { cycleAddress, instant, priority } from "./parts.js";

/** What was wrong: its sentence, or its name where there is none. */
export function sentence(alarm) {
  return capital(alarm.detail || alarm.condition.replaceAll("_", " ").toLowerCase());
}

export function mountAlarms(root, context) {
  const words = text.history.alarms;
  const list = new List(context, {
    path: "/alarms",
    key: "alarms",
    label: text.history.alarms.log,
    heads: [words.raised, words.priority, words.what, words.cycle],
    cells: (alarm) => [
      instant(alarm.raised_at),
      priority(alarm),
      sentence(alarm),
      alarm.cycle_id ? make("a", { href: cycleAddress(alarm.cycle_id), class: "history-open", "aria-label": `${words.cycle}: ${words.open}` }, words.open) : words.atRest,
    ],
    choices: { priority: ["high", "medium", "low"].map((name) => [name, text.history.priorities[name]]) },
    words: words.words,
    none: words.none,
    noneSuch: words.noneSuch,
  });
  root.replaceChildren(list.element);
  return () => {};
}
