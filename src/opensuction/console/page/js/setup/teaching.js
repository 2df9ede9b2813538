// The travel length, taught one step at a time.

import { newKey } from "../api.js";
import { make, mark, say, show } from "../dom.js";
import { phaseWords } from "../situation.js";
import { fill, text } from "../text.js";
import { number } from "../words.js";
import { answerLine, shown, stepButton, tried, whyNotMe } from "./part.js";

const LOOK_MS = 400;
const LOOK_MOVING_MS = 120; // contact with the carina ends after two seconds
const MAIN = { idle: "prepare", prepared: "begin", taught: "take" }; // what stands first

class Teaching {
  constructor(root, context, told) {
    this.context = context;
    const words = text.setup.teaching;
    this.step = make("h2", { class: "teaching-step" });
    this.track = make("ol", { class: "teaching-track" }, words.steps.map((name) => make("li", {}, name)));
    this.does = make("p", { class: "teaching-does", role: "status" });
    this.buttons = make("div", { class: "teaching-buttons" });
    this.head = make("dd", {});
    this.tip = make("dd", {});
    this.inside = make("dd", {});
    this.taught = make("dd", { class: "taught" });
    this.answer = answerLine();
    this.notes = { tip: make("dd", {}), head: make("dd", {}), taught: make("dd", {}), inside: make("dd", {}) };
    const values = make("dl", { class: "teaching-values" },
      ["tip", "head", "taught", "inside"].map((name) => make("div", {}, make("dt", {}, words[name]), this[name], this.notes[name])));
    for (const note of Object.values(this.notes)) note.className = "value-note";
    this.intro = make("p", { class: "soft" }, words.intro);
    root.replaceChildren(make("div", { class: "teaching" },
      this.intro,
      this.track, this.step, this.does, values, this.buttons, this.answer.element));
    this.show(told);
    this.end = context.live.subscribe((state) => this.follow(state));
    this.again();
  }

  follow(state) {
    const mm = (value) => (value === null || value === undefined ? text.bedside.unknown : `${number(value, 1)} mm`);
    say(this.head, mm(state.head_mm));
    say(this.tip, mm(state.tip_mm));
    say(this.notes.tip, state.contact ? text.bedside.tip.contact : state.tip_mm > 0 ? text.bedside.tip.below : text.bedside.tip.above);
  }

  again() {
    this.timer = setTimeout(() => this.look(), this.told.stage === "moving" ? LOOK_MOVING_MS : LOOK_MS);
  }

  async look() {
    try {
      const told = await this.context.api.watch("/teaching");
      if (!this.isGone) this.show(told);
    } catch {
      // The connection is shown elsewhere; what was known stays, and is looked for again.
    } finally {
      if (!this.isGone) this.again();
    }
  }

  show(told) {
    this.told = told;
    const words = text.setup.teaching;
    const at = this.stepNumber(told);
    [...this.track.children].forEach((one, index) => {
      mark(one, "data-state", index < at ? "done" : index === at ? "now" : "next");
      mark(one, "aria-current", index === at ? "step" : null);
    });
    say(this.step, fill(words.stepOf, { n: at + 1, all: words.steps.length, name: words.steps[at] }));
    say(this.does, this.doing(told, words));
    show(this.intro, told.stage === "idle");
    const range = fill(words.plausible, { least: told.least_mm, most: told.most_mm });
    const refused = !["nothing", "taken"].includes(told.result);
    say(this.taught, told.taught_mm !== null ? `${number(told.taught_mm, 1)} mm` : refused ? words.notTaken : words.none);
    say(this.notes.taught, refused && told.taught_mm === null ? `${told.sentence}; ${range}` : range);
    mark(this.taught, "data-refused", refused);
    const isInside = told.inside_s > 0;
    say(this.inside, isInside ? `${told.inside_s.toFixed(0)} s` : text.bedside.tip.out);
    say(this.notes.inside, fill(words.insideMost, { s: told.inside_most_s }));
    mark(this.inside, "data-late", isInside && told.inside_s > 0.6 * told.inside_most_s);
    this.showButtons(told, words);
  }

  /** Which of the five steps it is. */
  stepNumber(told) {
    if (told.stage === "taught") return 4;
    if (told.stage === "homing") return 3;
    if (told.stage === "moving") return told.taught_mm !== null ? 3 : told.is_away ? 2 : 1;
    if (told.stage === "busy" && told.is_prepared) return told.taught_mm !== null ? 3 : 1;
    return told.stage === "prepared" ? 1 : 0;
  }

  doing(told, words) {
    if (told.is_bench) return words.bench;
    if (told.stage === "idle") return `${words.does.idle} ${fill(words.known, { mm: shown(told.carina_mm), by: told.taught_by })}`;
    if (told.stage === "busy") {
      if (told.phase === "halted") return told.taught_mm !== null ? `${words.halted} ${words.stays}` : words.halted;
      return fill(words.does.busy, { phase: phaseWords(told.phase)[0].toLowerCase() });
    }
    if (told.stage === "moving" && told.taught_mm === null && told.feels) return `${words.does.moving} ${words.feels}`;
    return words.does[told.stage];
  }

  showButtons(told, words) {
    const mine = told.is_bench ? "" : whyNotMe(this.context.session, "teach");
    const steps = told.is_bench || mine ? [] : told.steps;
    const key = JSON.stringify([steps, told.taught_mm, mine, told.stage]);
    if (key === this.shownButtons) return;
    this.shownButtons = key;
    const had = this.buttons.contains(document.activeElement) ? document.activeElement.dataset.step : null;
    const main = told.stage === "moving" ? (told.taught_mm === null ? "confirm" : null) : MAIN[told.stage];
    const made = steps.map((name) => {
      const known = name === "begin" && told.stage === "taught" ? words.beginAgain : words[name];
      const label = [fill(known[0], { mm: told.taught_mm === null ? "" : number(told.taught_mm, 1) }), known[1]];
      const button = stepButton(label, () => this.take(name, button), name === main ? "primary" : "");
      mark(button, "data-step", name);
      return button;
    });
    this.buttons.replaceChildren(...made, ...(mine ? [make("p", { class: "setup-why" }, mine)] : []));
    const same = made.find((button) => button.dataset.step === had) || (had ? made[0] : null);
    if (same) same.focus();
  }

  take(step, button) {
    return tried(button, this.answer, async () => {
      const told = await this.context.api.post("/teaching", { step, version: this.told.version, key: newKey() });
      this.show(told);
      this.answer.told(step === "take" ? fill(text.setup.teaching.done, { mm: shown(told.carina_mm) }) : "", "good");
    });
  }

  unmount() {
    this.isGone = true;
    clearTimeout(this.timer);
    this.end();
  }
}

/** Show the part; gives what takes it away. */
export async function mountTeaching(root, context) {
  const teaching = new Teaching(root, context, await context.api.get("/teaching"));
  return () => teaching.unmount();
}

