// What a person may tell the machine besides start and stop: each button is there where it means
// something now. Rights and words of each are the machine's own table (js/machine_button.js).

import { make, say, show } from "../dom.js";
import { GOOD } from "../live.js";
import { BUTTONS } from "../machine_button.js";
import { requestAs } from "../request.js";
import { fill, text } from "../text.js";

const SAID_MS = 8000;

// Where each means something, in the order in which they stand.
const SHOWN = {
  "reset": (state) => (state.phase === "halted" && !state.locked_out) || state.alarms.some((one) => one.latched && !one.present),
  "oxygenated": (state) => state.phase === "parked" && ["requested", "not-asked", "skipped"].includes(state.preoxygenation),
  "oxygen-skipped": (state) => state.phase === "parked" && state.preoxygenation === "requested",
  "assessed": (state) => isResting(state) && state.passes > 0,
  "not-needed": (state) => state.assessment_due,
};

function isResting(state) {
  return ["parked", "halted", "out-of-service"].includes(state.phase);
}

export class Buttons {
  constructor(context) {
    this.context = context;
    this.made = Object.entries(SHOWN).map(([ask, isShown]) => {
      const { right, words } = BUTTONS[ask];
      const element = make("button", { type: "button", class: "tell", "data-ask": ask, hidden: true, onclick: () => this.press(ask) },
        make("span", {}, words.label), make("span", { class: "tell-hint" }, words.hint));
      return { element, right, isShown };
    });
    this.answer = make("p", { class: "tell-answer", role: "status" });
    this.oxygen = make("p", { class: "tell-answer" });
    this.service = make("a", { class: "tell to-setup", href: "#/setup", hidden: true }, text.bedside.toService);
    this.element = make("div", { class: "tells" }, this.made.map((one) => one.element), this.service, this.oxygen, this.answer);
  }

  async press(ask) {
    const told = await requestAs(this.context, ask);
    if (told === null) return;
    const { refusal } = told;
    const left_s = Math.ceil(this.context.live.state?.oxygen_left_s ?? 0) || 120;
    say(this.answer, refusal || fill(BUTTONS[ask].words.done, { s: left_s }));
    clearTimeout(this.timer);
    this.timer = setTimeout(() => say(this.answer, ""), SAID_MS);
  }

  update(state, link) {
    const { session } = this.context;
    for (const { element, right, isShown } of this.made) {
      const isTheirs = session.may(right) || session.name === null;
      show(element, isTheirs && link.kind === GOOD && isShown(state));
    }
    show(this.service, state.locked_out || state.phase === "out-of-service");
    const words = text.bedside.preoxygenation[state.preoxygenation];
    say(this.oxygen, words && state.oxygen_left_s > 0 ? fill(words, { s: Math.ceil(state.oxygen_left_s) }) : "");
  }
}
