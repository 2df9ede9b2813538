// The bedside view: where the catheter is, whether vacuum is on, whether all is well.

import { make, mark, say } from "../dom.js";
import { GOOD } from "../live.js";
import { phaseWords } from "../situation.js";
import { fill, text } from "../text.js";
import { age, capital, number } from "../words.js";
import { Buttons } from "./buttons.js";
import { Drawing } from "./drawing.js";
import { Gauge } from "./gauge.js";
import { Start } from "./start.js";
import { Monitor, Rest, Tip, Valve } from "./tile.js";

class Bedside {
  constructor(root, context) {
    this.context = context;
    this.drawing = new Drawing(context);
    this.tip = new Tip();
    this.gauge = new Gauge();
    this.valve = new Valve();
    this.monitor = new Monitor();
    this.rest = new Rest();
    this.start = new Start(context);
    this.buttons = new Buttons(context);
    this.build(root);
    this.ends = [
      context.live.subscribe(() => this.update()),
      context.live.follow(() => this.update()),
      context.session.subscribe(() => this.update()),
    ];
    this.take = (machine) => {
      this.drawing.load(machine);
      this.update();
    };
    context.machineChanged.add(this.take);
    if (context.machine) this.take(context.machine);
  }

  build(root) {
    const words = text.bedside;
    this.phase = make("span", { class: "phase-word big" }, words.unknown);
    this.left = make("span", { class: "phase-left" });
    this.meaning = make("p", { class: "phase-meaning" });
    this.old = make("span", { class: "stale-note" });
    this.element = make("div", { class: "bedside" },
      make("h1", { class: "hidden-title" }, words.title),
      make("section", { class: "phase", "aria-label": text.shell.now.phase }, make("p", { class: "phase-line" }, this.phase, this.left, this.old), this.meaning),
      this.drawing.element,
      make("div", { class: "readings" },
        make("div", { class: "pair" }, this.tip.element, this.gauge.element),
        make("div", { class: "quad" }, this.valve.element, this.monitor.elements),
        make("div", { class: "quad" }, this.rest.elements)));
    root.replaceChildren(this.element);
    this.context.aside.replaceChildren(this.start.element, this.buttons.element);
  }

  update() {
    const { live, machine } = this.context;
    const { link, known } = live;
    this.start.update(known || {}, link);
    const isLive = link.kind === GOOD && !link.hasFailed;
    mark(this.element, "data-stale", known !== null && !isLive);
    mark(this.element, "data-unknown", known === null);
    say(this.old, known !== null ? this.oldWords(link) : "");
    if (known === null) return;
    this.show(known);
    for (const part of [this.tip, this.gauge, this.valve, this.monitor, this.rest]) part.update(known, machine);
    this.drawing.update(known);
    this.buttons.update(known, link);
  }

  /** How old what is shown is; nothing where it is now. */
  oldWords(link) {
    if (link.hasFailed) return text.bedside.failed;
    return link.kind !== GOOD && link.age_s !== null ? fill(text.bedside.stale, { age: age(link.age_s) }) : "";
  }

  show(state) {
    const [name, meaning] = phaseWords(state.phase);
    say(this.phase, name);
    const comes = text.bedside.secretions[state.secretions] || "";
    const said = (state.phase === "halted" && capital(state.check_failure || "")) || state.check_title || meaning;
    say(this.meaning, [said, comes].filter(Boolean).join(" "));
    const left_s = state.phase_left_s;
    say(this.left, left_s === null ? "" : fill(text.bedside.left, { s: number(Math.ceil(left_s)) }));
    mark(this.element, "data-phase", state.phase);
  }

  unmount() {
    for (const end of this.ends) end();
    this.context.machineChanged.delete(this.take);
  }
}

/** Show the view; gives what takes it away. */
export function mount(root, context) {
  const view = new Bedside(root, context);
  return () => view.unmount();
}
