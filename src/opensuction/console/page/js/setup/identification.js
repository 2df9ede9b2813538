// The identification of a machine of this kind, with its loop, and its acceptance.

import { newKey } from "../api.js";
import { field, form } from "../dialog.js";
import { make, mark, say, show } from "../dom.js";
import { fill, text } from "../text.js";
import { answerLine, fact, shown, whyNotNow } from "./part.js";

const LOOK_MS = 1000;

class Identification {
  constructor(root, context, told) {
    this.context = context;
    this.version = told.version;
    const words = text.setup.identification;
    this.rests = make("p", {});
    this.run = told.runs[0] || null;
    this.begin = this.reasonForm(words.begin, "begin-reason", (reason) => this.start(reason));
    this.accept = this.reasonForm(words.accept, "accept-reason", (reason) => this.take(reason));
    this.answer = answerLine();
    this.why = make("p", { class: "setup-why", role: "status" });
    this.halts = make("p", { class: "notice", hidden: true });
    this.stage = make("p", { class: "run-stage", role: "status" });
    this.progress = make("progress", { max: 100, value: 0, "aria-label": words.states.running });
    this.result = make("div", { class: "run-result" });
    root.replaceChildren(make("div", { class: "setup-columns" },
      make("section", {}, make("p", { class: "soft" }, words.intro), this.rests,
        make("p", { class: "notice" }, told.measured), told.is_bench ? make("p", { class: "soft" }, words.bench) : null,
        this.begin.element, this.halts, this.accept.element, this.why, this.answer.element),
      make("section", {}, this.stage, this.progress, this.result)));
    this.showRests(told);
    this.show();
    this.timer = setInterval(() => this.look(), LOOK_MS);
    this.recolour = () => {
      this.drawn = null;
      this.show();
    };
    addEventListener("themechange", this.recolour);
  }

  reasonForm(label, id, send) {
    const reason = field(id, text.setup.reason, { maxlength: 500, autocomplete: "off" }, text.setup.reasonHint);
    const made = form({ reason }, label, async (values) => {
      await send(values.reason);
      reason.input.value = "";
    });
    return made;
  }

  showRests(told) {
    say(this.rests, fill(text.setup.identification.restsOn, { by: told.calibrated_by, kind: told.compensation }));
    this.version = told.version;
  }

  async start(reason) {
    this.run = await this.context.api.post("/identification", { reason, key: newKey() });
    this.drawn = null;
    this.show();
  }

  async take(reason) {
    this.run = await this.context.api.post(`/identification/${this.run.id}/accept`, { reason, version: this.version, key: newKey() });
    this.showRests(await this.context.api.get("/identification"));
    this.drawn = null;
    this.show();
  }

  async look() {
    this.showWhy();
    if (!this.run || this.run.state !== "running" || this.isAsking) return;
    this.isAsking = true;
    try {
      this.run = await this.context.api.watch(`/identification/${this.run.id}`);
      this.show();
    } catch {
      // The connection is shown elsewhere.
    } finally {
      this.isAsking = false;
    }
  }

  showWhy() {
    const may = this.context.session.may("calibrate");
    const isFound = this.run?.state === "found" && !this.run.accepted_by;
    const now = isFound ? whyNotNow(this.context) : "";
    say(this.why, may ? now : text.setup.identification.noRight);
    show(this.begin.element, may && this.run?.state !== "running" && !isFound);
    show(this.accept.element, may && isFound);
    show(this.halts, isFound && this.run.halts === true);
    if (isFound && this.run.halts) say(this.halts, this.haltWords(this.run.park_shift_mm));
    this.accept.submit.disabled = now !== "";
  }

  haltWords(shift_mm) {
    const words = text.setup.identification;
    return fill(words.halts, { mm: shown(Math.abs(shift_mm)), way: shift_mm > 0 ? words.ways.in : words.ways.out });
  }

  show() {
    const words = text.setup.identification;
    const { run } = this;
    this.showWhy();
    show(this.progress, run?.state === "running");
    if (!run) return;
    this.progress.value = 100 * (1 - Math.exp(-run.elapsed_s / run.usually_s));
    const stage = { stage: run.stage, elapsed: run.elapsed_s.toFixed(0), usually: run.usually_s };
    say(this.stage, run.state === "running" ? fill(words.stages, stage) : `${words.states[run.state]}${run.detail ? `: ${run.detail}` : ""}`);
    mark(this.stage, "data-state", run.state);
    if (run.state === "running" || this.drawn === run.id) return;
    this.drawn = run.id;
    this.drawResult(run, words);
  }

  async drawResult(run, words) {
    const { result } = run;
    this.result.replaceChildren();
    if (!result) return;
    const place = make("div", { class: "loop-plot", role: "img", "aria-label": fill(words.loopDescribe, { gap: shown(result.gap_mm) }) });
    this.result.replaceChildren(
      run.accepted_by ? make("p", { class: "setup-answer", "data-kind": "good" }, fill(words.accepted, { by: run.accepted_by })) : "",
      make("dl", { class: "facts" },
        fact(words.gap, `${shown(result.gap_mm)} mm`, fill(words.gapOfBuilt, { percent: (100 * result.gap_ratio).toFixed(0) })),
        result.validation ? fact(words.left, `${shown(result.validation.plays_rmse_mm)} mm RMS`) : null,
        result.servo ? fact(words.friction, `${shown(result.servo.friction_v)} V`) : null,
        result.servo ? fact(words.speed, `${shown(result.servo.velocity_v_s_per_mm)} V`) : null),
      make("figure", {}, place, make("figcaption", { class: "soft" }, words.loop)),
      make("details", {}, make("summary", {}, words.checks), this.checks(result, words)));
    if (!run.loop) return;
    const { default: loopPlot } = await import("../../vendor/loop_plot.js");
    if (place.isConnected) loopPlot(place, run.loop, place.clientWidth || 480);
  }

  checks(result, words) {
    return make("div", { class: "scroll" }, make("table", {},
      make("thead", {}, make("tr", {}, words.columns.map((name) => make("th", { scope: "col" }, name)))),
      make("tbody", {}, result.checks.map((one) => make("tr", {}, make("td", {}, one.name),
        make("td", {}, `${shown(one.value)} ${one.unit}`), make("td", {}, one.bound), make("td", {}, one.ok ? "✓" : "✗"))))));
  }

  unmount() {
    clearInterval(this.timer);
    removeEventListener("themechange", this.recolour);
  }
}

/** Show the part; gives what takes it away. */
export async function mountIdentification(root, context) {
  const identification = new Identification(root, context, await context.api.get("/identification"));
  return () => identification.unmount();
}
