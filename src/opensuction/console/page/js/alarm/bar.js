// The alarm bar: what a person must do now, first and largest. Everything in it is the machine's word;
// only what the machine cannot say (that it is not heard) is the page's own.

import { make, mark, say, show } from "../dom.js";
import { CONNECTING, GOOD, LOST } from "../live.js";
import { BUTTONS } from "../machine_button.js";
import { requestAs } from "../request.js";
import { isLeftInside, isResting, leftInsideWords, waitsFor } from "../situation.js";
import { fill, text } from "../text.js";
import { age, capital, countdown } from "../words.js";
import { AlarmList } from "./list.js";
import { Sound } from "./sound.js";

const MUTED_S = 120; // as the machine's own audio pause at most
const LONG = 38; // characters that fit in a line of the largest letters
const FITS = 72; // in two lines
const ORDER = ["none", "low", "medium", "high"];
const rank = (priority) => ORDER.indexOf(priority);
const louder = (one, other) => (rank(one) >= rank(other) ? one : other);

/** What fits of a remedy in the largest letters, at least its first sentence, and the rest. */
export function firstSentences(words) {
  let end = -1;
  for (let next = words.indexOf(". "); next >= 0; next = words.indexOf(". ", next + 1)) {
    if (end >= 0 && next > FITS) break;
    end = next;
  }
  if (words.length <= FITS || end < 0) return [words, ""];
  return [words.slice(0, end + 1), words.slice(end + 2)];
}

export class AlarmBar {
  constructor(context) {
    this.context = context;
    this.sound = new Sound();
    this.sound.onchange = () => this.update();
    this.pages = new Map(); // what the page itself has to say: name -> priority
    this.muted_until_ms = 0;
    this.lit = null;
    this.silent_s = null; // as of the last state, while something shown made no sound
    this.build();
    this.list = new AlarmList(context);
    context.live.subscribe(() => this.update());
    context.live.follow(() => this.update());
    this.learn();
  }

  build() {
    const words = text.alarm;
    this.lamp = make("div", { class: "alarm-lamp", "aria-hidden": "true" });
    this.kind = make("p", { class: "alarm-kind" });
    this.first = make("p", { class: "alarm-first" });
    this.rest = make("p", { class: "alarm-rest" });
    this.told = make("div", { class: "alarm-told", role: "alert", "aria-atomic": "true" }, this.kind, this.first, this.rest);
    const button = (act, label) => make("button", { type: "button", class: "alarm-button", onclick: act, hidden: true }, label);
    this.more = button(() => this.list.toggle(this.more), words.all);
    this.acknowledge = button(() => this.press("acknowledge"), words.acknowledge);
    this.pause = button(() => this.press("audio-pause"), words.pause);
    this.mute = button(() => this.toggleMute(), words.mute);
    this.allow = make("button", { type: "button", class: "allow-sound", hidden: true, onclick: () => this.sound.wake() }, words.allow);
    mark(this.allow, "title", words.allowDetail);
    this.answer = make("p", { class: "alarm-answer", role: "status" });
    this.element = make(
      "section",
      { class: "alarm-bar", "aria-label": words.region, "data-priority": "none" },
      this.lamp,
      this.told,
      make("div", { class: "alarm-side" },
        make("div", { class: "alarm-buttons" }, this.more, this.mute, this.pause, this.acknowledge),
        this.answer),
    );
  }

  /** Take in how alarms sound and flash; tried until it is known. */
  async learn() {
    try {
      const signals = await this.context.api.get("/alarm-signals");
      this.sound.learn(signals);
      this.update();
    } catch {
      setTimeout(() => this.learn(), 3000);
    }
  }

  /** What only the page knows, such as a stop that was not delivered; null: over. */
  page(name, priority) {
    if (priority === null) this.pages.delete(name);
    else this.pages.set(name, priority);
    this.update();
  }

  async press(ask) {
    const told = await requestAs(this.context, ask);
    if (told === null) return;
    const { refusal } = told;
    say(this.answer, refusal || "");
    if (refusal) setTimeout(() => say(this.answer, ""), 8000);
  }

  toggleMute() {
    const now_ms = performance.now();
    this.muted_until_ms = this.muted_until_ms > now_ms ? 0 : now_ms + 1000 * MUTED_S;
    this.update();
  }

  update() {
    if (!this.list) return;
    const { link } = this.context.live;
    const state = this.state(link);
    const shown = this.judge(state, link);
    mark(this.element, "data-priority", shown.priority);
    mark(this.element, "data-kind", shown.kind);
    say(this.kind, shown.above);
    say(this.first, shown.first);
    mark(this.first, "data-long", shown.first.length > LONG);
    say(this.rest, shown.rest);
    this.flash(shown.priority);
    this.sound.play(this.audible(state, link));
    this.remind(state, link);
    this.buttons(state, link);
    this.list.update(state, link);
  }

  /** What is gone by: the newest; where the machine is not heard, the last that it said. */
  state(link) {
    const { state, known } = this.context.live;
    return link.kind === GOOD ? state : known;
  }

  /** What is said, and how urgent it is. */
  judge(state, link) {
    const words = text.alarm;
    if (link.kind === CONNECTING) return { kind: "quiet", priority: "none", above: "", first: words.notKnown, rest: "" };
    if (link.kind !== GOOD) return this.unheard(state, link);
    const alarm = state.alarms[0];
    if (isLeftInside(state)) {
      const [first, rest] = [leftInsideWords(state), alarm ? alarm.remedy : ""];
      const priority = louder(state.priority, "none");
      return { kind: "alarm", priority, above: this.above(alarm), first, rest };
    }
    if (alarm) {
      const [first, rest] = firstSentences(alarm.remedy);
      return { kind: "alarm", priority: state.priority, above: this.above(alarm), first, rest };
    }
    const ask = waitsFor(state);
    if (ask) return { kind: "ask", priority: "none", above: "", first: ask, rest: this.refusal(state) };
    return { kind: "quiet", priority: "none", above: "", first: words.none, rest: this.refusal(state) };
  }

  above(alarm) {
    if (!alarm) return "";
    const words = text.alarm;
    const parts = [words.priorities[alarm.priority], capital(alarm.sentence)];
    if (!alarm.present) parts.push(words.over);
    if (alarm.acknowledged) parts.push(words.acknowledged);
    return parts.join(" · ");
  }

  refusal(state) {
    return state.refusal ? fill(text.bedside.start.blocked, { why: state.refusal.sentence }) : "";
  }

  unheard(state, link) {
    const words = text.alarm;
    const isLost = link.kind === LOST;
    const old = link.age_s === null ? words.lostNever : fill(words.lostAge, { age: age(link.age_s) });
    const [first, rest] = firstSentences(isLost ? words.lostRemedy : words.silentRemedy);
    return {
      kind: "alarm",
      priority: this.unheardPriority(state),
      above: `${isLost ? words.lost : words.silentControl} · ${old}`,
      first,
      rest: isLost ? `${rest} ${words.trying}` : rest,
    };
  }

  /** High where the catheter was, or was going, inside when the machine was last heard. */
  unheardPriority(state) {
    const { state: told, link } = this.context.live;
    if (link.kind !== LOST && told && !told.connected) return told.priority;
    return state && (state.is_inside !== false || !isResting(state)) ? "high" : "medium";
  }

  audible(state, link) {
    let wanted = "none";
    if (link.kind === GOOD) {
      wanted = state.audible || "none";
      this.muted_until_ms = 0;
    } else if (link.kind !== CONNECTING) {
      wanted = louder(this.unheardPriority(state), state?.priority || "none");
      if (performance.now() < this.muted_until_ms) wanted = "none";
    }
    for (const priority of this.pages.values()) wanted = louder(priority, wanted);
    return wanted;
  }

  /** The machine counts how long something shown has been silent, and begins anew when it reminds. */
  remind(state, link) {
    const silent_s = link.kind === GOOD && state.audible === "none" && state.alarms.length > 0 ? state.silent_s : null;
    if (silent_s !== null && this.silent_s !== null && silent_s < this.silent_s) this.sound.remind();
    this.silent_s = silent_s;
  }

  /** Light by the machine's figures: flashing, steady or dark. */
  flash(priority) {
    const signal = this.sound.signals[priority];
    const key = signal ? priority : null;
    if (key === this.lit) return;
    this.lit = key;
    for (const running of this.lamp.getAnimations()) running.cancel();
    mark(this.lamp, "data-lit", signal && signal.duty_ratio > 0);
    if (!signal || signal.flash_hz === 0) return;
    const jump = "steps(1, end)";
    this.lamp.animate(
      [
        { opacity: 1, offset: 0, easing: jump },
        { opacity: 0, offset: signal.duty_ratio, easing: jump },
        { opacity: 0, offset: 1 },
      ],
      { duration: 1000 / signal.flash_hz, iterations: Infinity },
    );
  }

  buttons(state, link) {
    const words = text.alarm;
    const { session } = this.context;
    const mayAttend = session.may(BUTTONS.acknowledge.right) || session.name === null;
    const isGood = link.kind === GOOD;
    const alarms = isGood ? state.alarms : [];
    show(this.more, alarms.length > 1 || this.list.isOpen);
    say(this.more, this.list.isOpen ? words.fewer : fill(words.more, { n: alarms.length - 1 }));
    show(this.acknowledge, mayAttend && alarms.some((one) => !one.acknowledged));
    const paused_s = isGood ? state.pause_left_s : 0;
    show(this.pause, mayAttend && isGood && (paused_s > 0 || state.audible !== "none"));
    say(this.pause, paused_s > 0 ? `${fill(words.paused, { left: countdown(paused_s) })}. ${words.resume}` : words.pause);
    const muted_s = (this.muted_until_ms - performance.now()) / 1000;
    show(this.mute, link.kind !== GOOD && link.kind !== CONNECTING);
    say(this.mute, muted_s > 0 ? fill(words.muted, { left: countdown(muted_s) }) : words.mute);
    show(this.allow, this.sound.state === "blocked");
  }
}
