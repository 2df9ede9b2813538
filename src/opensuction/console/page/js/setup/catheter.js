// The catheter's change, and the 24 h that it may be used.

import { Refused, newKey } from "../api.js";
import { field, form } from "../dialog.js";
import { make, mark, say } from "../dom.js";
import { request } from "../request.js";
import { fill, text } from "../text.js";
import { age, countdown } from "../words.js";
import { answerLine, fact, stepButton, tried, whyNotMe } from "./part.js";

const LOOK_MS = 1000;

class Catheter {
  constructor(root, context, told) {
    this.context = context;
    this.isNew = false; // one has been put in since the machine was taken out of service
    const words = text.setup.catheter;
    this.facts = make("dl", { class: "facts" });
    this.clock = make("p", { class: "catheter-clock" });
    this.track = make("ol", { class: "teaching-track" }, words.steps.map((name) => make("li", {}, name)));
    this.action = make("div", { class: "teaching-buttons" });
    this.answer = answerLine();
    root.replaceChildren(make("div", { class: "setup-columns" },
      make("section", {}, this.track, this.action, this.answer.element),
      make("section", {}, make("h2", {}, words.left), this.clock, this.facts)));
    this.show(told);
    this.timer = setInterval(() => this.look(), LOOK_MS);
  }

  async look() {
    try {
      this.show(await this.context.api.watch("/catheter"));
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
    }
  }

  show(told) {
    const words = text.setup.catheter;
    this.told = told;
    if (!told.is_out_of_service) this.isNew = false;
    say(this.clock, told.left_s > 0 ? countdown(told.left_s) : words.over);
    mark(this.clock, "data-over", told.left_s <= 0);
    const use = told.first_use_s_ago === null ? words.unused : fill(words.firstUse, { age: age(told.first_use_s_ago) });
    this.facts.replaceChildren(fact(words.label, told.label), fact(fill(words.size, { fr: told.size_fr }), use));
    const at = told.is_out_of_service ? (this.isNew ? 2 : 1) : 0;
    [...this.track.children].forEach((one, index) => {
      mark(one, "data-state", index < at ? "done" : index === at ? "now" : "next");
      mark(one, "aria-current", index === at ? "step" : null);
    });
    this.showAction(told, words);
  }

  showAction(told, words) {
    const mine = whyNotMe(this.context.session, "change-catheter");
    const canLeave = ["parked", "halted"].includes(told.phase);
    const key = JSON.stringify([told.is_out_of_service, this.isNew, canLeave, mine]);
    if (key === this.shownAction) return;
    this.shownAction = key;
    if (mine) {
      this.action.replaceChildren(make("p", { class: "setup-why" }, mine));
    } else if (!told.is_out_of_service) {
      const button = stepButton(words.service, () => this.press(button, "service"), "primary");
      button.disabled = !canLeave;
      this.action.replaceChildren(button, ...(canLeave ? [] : [make("p", { class: "setup-why" }, words.parkedOnly)]));
    } else {
      const back = this.isNew ? words.back : words.backSame;
      const button = stepButton(back, () => this.press(button, "return-to-service"), this.isNew ? "primary" : "");
      this.action.replaceChildren(...(this.isNew ? [] : [this.labelForm(told, words)]), button);
    }
  }

  labelForm(told, words) {
    const label = field("label", words.newLabel, { maxlength: 64, autocomplete: "off", spellcheck: "false" }, fill(words.newHint, { fr: told.size_fr }));
    const made = form({ label }, words.changed, async (values) => {
      const found = await this.context.api.put("/catheter", { label: values.label.trim(), key: newKey() });
      this.isNew = true;
      this.answer.told(fill(words.done, { label: found.label }), "good");
      this.show(found);
    });
    return made.element;
  }

  press(button, ask) {
    return tried(button, this.answer, async () => {
      const { refusal } = await request(this.context.api, ask);
      this.answer.told(refusal || "", refusal ? "bad" : "");
      await this.look();
    });
  }

  unmount() {
    clearInterval(this.timer);
  }
}

/** Show the part; gives what takes it away. */
export async function mountCatheter(root, context) {
  const catheter = new Catheter(root, context, await context.api.get("/catheter"));
  return () => catheter.unmount();
}
