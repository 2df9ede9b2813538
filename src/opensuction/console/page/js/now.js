// On views other than the bedside: what the machine does now, small, above STOP.

import { make, mark, say } from "./dom.js";
import { GOOD } from "./live.js";
import { phaseWords } from "./situation.js";
import { text } from "./text.js";
import { number } from "./words.js";

export class NowPanel {
  constructor(context) {
    const words = text.shell.now;
    this.values = {};
    const row = (name) => {
      this.values[name] = make("dd", {}, text.bedside.unknown);
      return make("div", {}, make("dt", {}, words[name]), this.values[name]);
    };
    this.element = make("dl", { class: "now", "aria-label": words.title }, row("phase"), row("tip"), row("vacuum"));
    context.live.subscribe(() => this.update(context.live));
    context.live.follow(() => this.update(context.live));
  }

  update(live) {
    const state = live.known;
    mark(this.element, "data-stale", live.link.kind !== GOOD || live.link.hasFailed);
    if (!state || !this.element.checkVisibility()) return;
    const unknown = text.bedside.unknown;
    say(this.values.phase, phaseWords(state.phase)[0]);
    say(this.values.tip, tipWords(state) ?? unknown);
    say(this.values.vacuum, state.vacuum_mmhg === null ? unknown : `${number(state.vacuum_mmhg)} mmHg`);
  }
}

function tipWords(state) {
  if (state.is_inside === false) return text.bedside.tip.out;
  return state.tip_mm === null ? null : `${number(state.tip_mm)} mm`;
}
