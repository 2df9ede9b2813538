// STOP: at the same place on every view, never disabled, without sign-in. Says within 100 ms that it
// was pressed, tries again by itself for some seconds, and says loudly where it was not delivered.

import { Refused, newKey } from "./api.js";
import { make, mark, say, show } from "./dom.js";
import { Pointers } from "./pointers.js";
import { isResting, phaseWords } from "./situation.js";
import { fill, text } from "./text.js";
import { after } from "./timer.js";

const KEY = "F8";
const PRESSED = "pressed"; // the machine's own word: the button went down
const ONE_TRY_MS = 700;
const TRIES = 8;
const BETWEEN_MS = 150;
const SHOWN_MS = 6000;

const pause = (ms) => new Promise((done) => { after(ms, done); });

export class Stop {
  /** alarm.page(name, priority): sounds what only the page knows. */
  constructor(api, live, alarm) {
    this.api = api;
    this.live = live;
    this.alarm = alarm;
    this.press_number = 0;
    const words = text.shell.stop;
    this.word = make("span", { class: "stop-word" }, words.label);
    this.said = make("span", { class: "stop-key" }, words.key);
    this.button = make(
      "button",
      { class: "stop", type: "button", id: "stop", "aria-label": words.describe },
      this.word,
      this.said,
    );
    this.status = make("div", { class: "stop-status", role: "status" });
    this.failure = this.makeFailure();
    this.element = make("div", { class: "stop-place" }, this.status, this.button);
    this.listen();
  }

  makeFailure() {
    const words = text.shell.stop;
    this.failureNext = make("p", {}, words.again);
    this.failureDetail = make("p", { class: "not-stopped-detail" });
    return make(
      "div",
      { class: "not-stopped", role: "alert", hidden: true },
      make("p", { class: "not-stopped-word" }, words.failed),
      make("p", { class: "not-stopped-remedy" }, words.failedRemedy),
      this.failureDetail,
      this.failureNext,
      make("button", { type: "button", onclick: () => this.settle() }, text.shell.close),
    );
  }

  listen() {
    // As the finger comes down, not as it leaves; a click without a pointer is a key's or a reader's.
    const pointers = new Pointers(this.button);
    this.button.addEventListener("pointerdown", () => this.press());
    this.button.addEventListener("click", (event) => {
      if (!pointers.end(event)) this.press();
    });
    addEventListener(
      "keydown",
      (event) => {
        if (event.key !== KEY || event.repeat) return;
        event.preventDefault();
        this.press();
      },
      { capture: true },
    );
  }

  /** One press: until it is delivered, or until all tries have failed, or the next press. */
  async press() {
    this.press_number += 1;
    const mine = this.press_number;
    clearTimeout(this.hide);
    this.show("sending", text.shell.stop.sending);
    for (let attempt = 1; attempt <= TRIES; attempt += 1) {
      try {
        // A key of its own each time: to stop twice harms nobody, and the answer is this try's.
        const body = { ask: "abort", key: newKey() };
        const answer = await this.api.stop("/requests", body, ONE_TRY_MS);
        if (mine !== this.press_number) return;
        if (answer?.verdict === PRESSED) {
          this.deliver(answer);
          return;
        }
        this.fail(fill(text.shell.stop.verdict, { verdict: answer?.verdict ?? "" }));
      } catch (error) {
        if (mine !== this.press_number) return;
        this.fail(error instanceof Refused ? error.detail : String(error));
      }
      await pause(BETWEEN_MS);
      if (mine !== this.press_number) return;
    }
    say(this.failureNext, text.shell.stop.givenUp);
  }

  deliver(answer) {
    this.settle();
    const state = this.live.state;
    const phase = answer?.phase || state?.phase;
    const idle = state && isResting(state) && !state.is_inside && isResting({ phase });
    const words = text.shell.stop;
    this.show("delivered", idle ? words.nothing : fill(words.delivered, { phase: phaseWords(phase)[0] }));
    this.hide = setTimeout(() => this.show(null, ""), SHOWN_MS);
  }

  /** Said at the first try that failed, while the next ones are made. */
  fail(detail) {
    say(this.failureNext, text.shell.stop.again);
    this.show("failed", text.shell.stop.failed);
    say(this.failureDetail, fill(text.shell.stop.failedDetail, { detail }));
    show(this.failure, true);
    this.alarm.page("not-stopped", "high");
  }

  settle() {
    show(this.failure, false);
    this.alarm.page("not-stopped", null);
    if (this.button.dataset.state === "failed") this.show(null, "");
  }

  show(state, words) {
    mark(this.button, "data-state", state);
    say(this.said, state === "sending" ? words : text.shell.stop.key);
    say(this.status, words);
  }
}
