// The planner's arithmetic of a draft: times, vacuum, guidelines.

import { draw, make, say } from "../dom.js";
import { fill, text } from "../text.js";
import { fact, shown } from "./part.js";

const PARTS = ["preload", "insertion", "back_off", "build", "dwell", "withdrawal"];
const WIDTH = 400;
const HEIGHT = 26;

/** Sentence and panel; show(plan) draws one, or says that there is none. */
export function arithmetic() {
  const element = make("div", { class: "plan" });
  const sentence = make("p", { class: "plan-sentence", role: "status" }, text.setup.protocol.planning);
  return {
    element,
    sentence,
    show(plan) {
      say(sentence, plan ? plan.sentence : text.setup.protocol.unplanned);
      element.replaceChildren(...(plan ? drawn(plan) : []));
    },
  };
}

function drawn(plan) {
  const words = text.setup.protocol;
  const { times_s: times } = plan;
  const unit = (value, name) => (value === null ? text.bedside.unknown : `${shown(value)} ${name}`);
  return [
    bar(plan),
    make("ul", { class: "plan-times" }, PARTS.filter((name) => times[name] > 0).map((name) =>
      make("li", { "data-time": name }, `${words.times[name]} ${times[name].toFixed(1)} s`))),
    make("dl", { class: "facts" },
      fact(words.total, plan.total_s === null ? text.bedside.unknown : `${plan.total_s.toFixed(1)} s`),
      fact(words.vacuum, unit(plan.vacuum_mmhg, "mmHg")),
      fact(words.way, unit(plan.way_mm, "mm")),
      fact(words.toCap, unit(plan.left_to_cap_mm, "mm")),
      Object.entries(words.budgets).map(([name, label]) => fact(label, budget(words, times[name], plan.budgets_s[name])))),
    make("h3", {}, words.guidelines),
    make("table", { class: "guidelines" }, make("tbody", {}, plan.guidelines.map((one) => row(words, one)))),
  ];
}

function budget(words, value, most) {
  if (value === null || most === null) return text.bedside.unknown;
  return fill(words.ofBudget, { value: value.toFixed(1), most: Number(most.toFixed(1)) });
}

function row(words, one) {
  const limit = fill(one.is_strict ? words.below : words.atMost, { limit: shown(one.limit), unit: one.unit }).trim();
  return make("tr", { "data-ok": one.ok ? "true" : "false" },
    make("th", { scope: "row" }, words.guidelineNames[one.name] || one.name),
    make("td", {}, `${one.unit === "s" && one.value !== null ? one.value.toFixed(1) : shown(one.value)} ${one.unit}`.trim()),
    make("td", {}, limit),
    make("td", { class: "verdict" }, one.ok ? `✓ ${words.kept}` : `✗ ${words.broken}`));
}

/** The cycle as a bar, one piece a phase. */
function bar(plan) {
  const { times_s: times } = plan;
  const whole = PARTS.reduce((sum, name) => sum + (times[name] || 0), 0);
  const pieces = [];
  let from = 0;
  for (const name of PARTS) {
    const width = whole > 0 ? (WIDTH * (times[name] || 0)) / whole : 0;
    if (width > 0) pieces.push(draw("rect", { x: from, y: 0, width: Math.max(width - 1, 0.5), height: HEIGHT, class: `time-${name}` }));
    from += width;
  }
  return draw("svg", { class: "plan-bar", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", "aria-hidden": "true" }, ...pieces);
}
