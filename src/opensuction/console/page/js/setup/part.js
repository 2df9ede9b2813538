// What the parts of the set-up share: why nothing can be changed now, refusals, answers.

import { Refused } from "../api.js";
import { make, mark, say } from "../dom.js";
import { GOOD } from "../live.js";
import { phaseWords } from "../situation.js";
import { fill, text } from "../text.js";

/** Why settings cannot change now; empty where they can. */
export function whyNotNow(context) {
  const { live } = context;
  if (live.link.kind !== GOOD || !live.state) return text.setup.notLive;
  if (live.state.phase === "parked") return "";
  return fill(text.setup.notParked, { phase: phaseWords(live.state.phase)[0].toLowerCase() });
}

/** Why this person cannot change anything here; empty where one of the rights is there. */
export function whyNotMe(session, ...rights) {
  if (session.name === null) return text.setup.signIn;
  return rights.some((right) => session.may(right)) ? "" : text.setup.observer;
}

/** A line that says how it went: told("...", "good" | "bad" | ""). */
export function answerLine() {
  const element = make("p", { class: "setup-answer", role: "status" });
  return {
    element,
    told(words, kind = "") {
      mark(element, "data-kind", kind || null);
      say(element, words);
    },
  };
}

/** Do something once at a time; what is refused is said, and anything else is a fault. */
export async function tried(button, answer, act) {
  if (button.getAttribute("aria-busy") === "true") return;
  mark(button, "aria-busy", "true");
  try {
    await act();
  } catch (error) {
    if (!(error instanceof Refused)) throw error;
    answer.told(error.errors.length === 1 && !error.detail ? error.errors[0].detail : error.detail, "bad");
  } finally {
    mark(button, "aria-busy", null);
  }
}

/** A number as a form shows it: no more digits than mean something. */
export function shown(value) {
  if (value === null || value === undefined) return "";
  return String(Number(Number(value).toPrecision(4)));
}

/** A row of a list of facts. */
export function fact(name, value, note = "") {
  return make("div", { class: "fact" }, make("dt", {}, name), make("dd", {}, value, note ? make("span", { class: "fact-note" }, note) : null));
}

/** A big button with a hint. */
export function stepButton(words, onclick, kind = "") {
  return make("button", { type: "button", class: `step-button ${kind}`, onclick },
    make("span", { class: "step-word" }, words[0]), make("span", { class: "step-hint" }, words[1]));
}
