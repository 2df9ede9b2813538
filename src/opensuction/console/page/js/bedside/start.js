// START: held for a second, by finger, mouse or key; says what it will do, and why it cannot.

import { confirm } from "../dialog.js";
import { make, mark, say } from "../dom.js";
import { Pointers } from "../pointers.js";
import { request } from "../request.js";
import { whyNoStart } from "../situation.js";
import { fill, text } from "../text.js";

const HOLD_MS = 1000;
const HINT_MS = 4000;
const KEYS = new Set([" ", "Enter"]);

function contains(button, event) {
  const { left, right, top, bottom } = button.getBoundingClientRect();
  return event.clientX >= left && event.clientX <= right && event.clientY >= top && event.clientY <= bottom;
}

export class Start {
  constructor(context) {
    this.context = context;
    this.began_ms = null;
    this.why = "";
    this.hint = null;
    this.isBusy = false;
    const words = text.bedside.start;
    this.fill = make("span", { class: "start-fill", "aria-hidden": "true" });
    this.word = make("span", { class: "start-word" }, words.label);
    this.plan = make("span", { class: "start-plan" });
    this.said = make("span", { class: "start-said" });
    this.button = make("button", { type: "button", class: "start", id: "start", "aria-describedby": "start-why" }, this.fill, this.word, this.plan, this.said);
    this.blocked = make("p", { class: "start-why", id: "start-why", role: "status" });
    this.element = make("div", { class: "start-place" }, this.button, this.blocked);
    this.listen();
  }

  listen() {
    const { button } = this;
    const pointers = new Pointers(button);
    button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      button.setPointerCapture(event.pointerId);
      this.begin();
    });
    // What is captured goes on to say where it is: off the button it is no press any more.
    button.addEventListener("pointermove", (event) => {
      if (!contains(button, event)) this.release();
    });
    for (const kind of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) button.addEventListener(kind, () => this.release());
    button.addEventListener("contextmenu", (event) => event.preventDefault());
    button.addEventListener("keydown", (event) => {
      if (!KEYS.has(event.key)) return;
      event.preventDefault();
      if (!event.repeat) this.begin();
    });
    button.addEventListener("keyup", (event) => {
      if (KEYS.has(event.key)) this.release();
    });
    // Neither pointer nor key: a screen reader, or a switch that cannot hold.
    button.addEventListener("click", (event) => {
      if (!pointers.end(event)) this.askInstead();
    });
    addEventListener("visibilitychange", () => this.release());
  }

  begin() {
    if (this.began_ms !== null || this.isBusy) return;
    if (this.why) {
      if (this.context.session.name === null && this.why === text.bedside.start.why.signIn) this.context.askSignIn();
      return;
    }
    this.began_ms = performance.now();
    this.tell(text.bedside.start.holding);
    mark(this.button, "data-held", true);
    const step = () => {
      if (this.began_ms === null) return;
      const share = Math.min((performance.now() - this.began_ms) / HOLD_MS, 1);
      this.fill.style.setProperty("transform", `scaleX(${share})`);
      if (this.why) this.stopHolding();
      else if (share >= 1) this.send();
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  release() {
    if (this.began_ms === null) return;
    this.stopHolding();
    this.tell(text.bedside.start.tooShort, HINT_MS);
  }

  stopHolding() {
    this.began_ms = null;
    mark(this.button, "data-held", null);
    this.fill.style.setProperty("transform", "scaleX(0)");
    this.tell("");
  }

  async askInstead() {
    if (this.why || this.isBusy || this.began_ms !== null) return;
    const words = text.bedside.start;
    const sentence = fill(words.confirm, { plan: this.sentence() });
    if (await confirm(words.label, sentence, words.yes)) this.send();
  }

  async send() {
    this.stopHolding();
    if (this.isBusy || this.why) return;
    this.isBusy = true;
    this.tell(text.bedside.start.sending);
    const { refusal } = await request(this.context.api, "start");
    this.isBusy = false;
    this.tell(refusal || text.bedside.start.sent, refusal ? 2 * HINT_MS : HINT_MS);
  }

  /** Say something under the button for a while; for as long as nothing else is said without one. */
  tell(words, for_ms = null) {
    clearTimeout(this.timer);
    this.hint = words || null;
    if (words && for_ms) this.timer = setTimeout(() => this.tell(""), for_ms);
    this.show();
  }

  sentence() {
    return (this.context.machine?.plan_sentence || "").replace(/(\d) (?=[a-zA-Z])/g, "$1\u00a0"); // no line ends before a unit
  }

  update(state, link) {
    this.why = whyNoStart(state, link, this.context.session) || "";
    this.show();
  }

  show() {
    const words = text.bedside.start;
    const sentence = this.sentence();
    mark(this.button, "aria-disabled", this.why !== "" ? "true" : null);
    mark(this.button, "aria-label", fill(words.describe, { plan: sentence }));
    say(this.plan, sentence);
    say(this.said, this.why ? "" : words.hold);
    say(this.blocked, this.hint || (this.why ? fill(words.blocked, { why: this.why }) : ""));
  }
}
