// Signals at full rate: every tick of the control loop, as it comes.

import { machineNow } from "../clock.js";
import { make, mark, say, show } from "../dom.js";
import { fill, text } from "../text.js";
import { Buffer } from "./buffer.js";
import { Chooser } from "./chooser.js";
import { aboutOf, csv, save } from "./export.js";
import { Happened } from "./happened.js";
import { Loop } from "./loop.js";
import { Marks } from "./marks.js";
import { Plots } from "./plots.js";
import { LOOP, PRESETS, presetOf, remember, remembered } from "./preset.js";
import { Stream } from "./stream.js";
import { SPANS_S, Window } from "./window.js";

const RATE_MS = 1000;
const LATE_S = 1.5; // rows that are so much older than what the bedside shows wait somewhere on the way
const FILLS_MS = 2000; // so long the rows of the last seconds may take to come, which a connection begins with

class Signals {
  constructor(root, context, listed) {
    this.context = context;
    this.known = new Map(listed.channels.map((one) => [one.name, one]));
    this.names = remembered(this.known);
    this.facts = null; // of the control process
    this.window = new Window();
    this.marks = new Marks();
    this.hasLoop = false;
    this.figures = { frames: 0, rows: 0, missed: 0, since_ms: performance.now(), drawn: 0 };
    this.plots = new Plots({ window: this.window, marks: this.marks, live: () => this.buffer, offset: () => this.offset, act: this.acts() });
    this.loop = new Loop();
    this.happened = new Happened(this.marks, () => this.offset, (one) => this.lookAt(one));
    this.chooser = new Chooser(listed.channels, (names) => this.choose(names));
    this.chooser.onclose = () => {
      mark(this.element, "data-choosing", false);
      this.channelsButton.focus();
    };
    this.build(root);
    this.repaint = () => this.themeChanged();
    this.scheme = matchMedia("(prefers-color-scheme: dark)");
    addEventListener("themechange", this.repaint);
    this.scheme.addEventListener("change", this.repaint);
    this.choose(this.names);
    this.request = requestAnimationFrame(() => this.frame());
  }

  get offset() {
    return this.facts?.utc_offset_s ?? ((machineNow() ?? Date.now()) - performance.now()) / 1000;
  }

  build(root) {
    const words = text.signals;
    const button = (label, onclick, more = {}) => make("button", { type: "button", onclick, ...more }, label);
    this.pauseButton = button(words.pause, () => this.toggle(), { class: "primary signals-pause" });
    this.spans = SPANS_S.map((span_s) => button(fill(words.seconds, { s: span_s }), () => this.span(span_s), { "data-span": span_s }));
    this.presets = make("select", { "aria-label": words.preset, onchange: () => this.preset(this.presets.value) },
      ...Object.entries(words.presets).map(([name, title]) => make("option", { value: name }, title)));
    this.channelsButton = button(words.channels, () => {
      mark(this.element, "data-choosing", true);
      this.chooser.open(this.names);
    });
    this.loopButton = button(words.loopButton, () => this.toggleLoop(), { "aria-pressed": "false" });
    this.status = make("p", { class: "signals-status", role: "status" }, words.state.begins);
    this.lack = make("p", { class: "signals-lack" });
    const zoom = (label, glyph, act) => button(glyph, act, { "aria-label": label, title: label, class: "signals-glyph" });
    const moves = make("div", { class: "row signals-moves" },
      zoom(words.zoomIn, "+", () => this.zoom(0.5, null)), zoom(words.zoomOut, "−", () => this.zoom(2, null)),
      zoom(words.earlier, "◀", () => this.pan(-80)), zoom(words.later, "▶", () => this.pan(80)),
      zoom(words.put.a, "A", () => this.put("a")), zoom(words.put.b, "B", () => this.put("b")),
      zoom(words.clear, "✕", () => this.clear()));
    this.element = make("div", { class: "signals" },
      make("h1", { class: "hidden-title" }, words.title),
      make("div", { class: "row signals-tools" }, this.pauseButton,
        make("div", { class: "segments", role: "group", "aria-label": words.window }, ...this.spans),
        this.presets, this.channelsButton, this.loopButton, button(words.save, () => this.save())),
      make("div", { class: "signals-said" }, this.status, this.lack), this.chooser.element,
      make("div", { class: "signals-body" }, this.plots.element, this.loop.element),
      make("div", { class: "signals-below" }, moves, make("p", { class: "signals-help" }, words.help)));
    show(this.loop.element, false);
    root.replaceChildren(this.element);
    this.context.aside.replaceChildren(this.happened.element);
    this.element.figures = this.figures;
    this.showTools();
  }

  acts() {
    return {
      zoom: (factor, x) => this.zoom(factor, x),
      pan: (pixels) => this.pan(pixels),
      tap: (x) => this.put(this.plots.next, x),
      nudge: (pixels) => this.nudge(pixels),
      toggle: () => this.toggle(),
      put: (name) => this.put(name),
      back: () => this.resume(),
    };
  }

  /** Draw these channels from now on; as much of what has been as the machine still has comes first. */
  choose(names) {
    this.stream?.close();
    this.names = names;
    remember(names);
    const all = [...new Set([...names, ...LOOP])];
    this.window.thaw();
    this.plots.clear();
    this.buffer = new Buffer(all.map((name) => this.known.get(name)));
    this.plots.choose(this.buffer, names);
    this.stream = new Stream(all, {
      frame: (frame) => this.take(frame),
      source: (facts) => this.follow(facts),
      event: (event) => this.marks.add(event),
      ended: (reason) => {
        this.reason = reason;
        this.context.session.look();
      },
    });
    this.showTools();
  }

  take(frame) {
    if (this.isReplaced) {
      this.isReplaced = false;
      this.marks.add({ what: "source", name: "source", detail: "", time_s: frame.time_s, until_s: this.buffer.last_s ?? frame.time_s });
    }
    this.figures.rows += this.buffer.push(frame);
    this.figures.missed = this.buffer.missed;
  }

  follow(facts) {
    this.isReplaced = this.facts !== null && this.facts.run !== facts.run;
    this.facts = facts;
  }

  frame() {
    this.request = requestAnimationFrame(() => this.frame());
    this.say();
    const { window, plots, buffer } = this;
    const number = window.isLive ? buffer.next : -1;
    if ((number === this.drawn && !plots.isDirty) || buffer.next === 0) return;
    this.drawn = number;
    plots.isDirty = false;
    plots.draw();
    if (this.hasLoop) this.loop.draw(window.buffer(buffer), ...window.ends(buffer), window.isLive);
    this.figures.frames += 1;
  }

  /** How far the rows are behind the machine's newest state, which comes by a connection of its own. */
  get late_s() {
    const { live } = this.context;
    const { buffer, facts } = this;
    if (!live.isLive || !facts || buffer.next === 0) return 0;
    const newest = buffer.tick[(buffer.next - 1) & buffer.mask];
    const behind = live.known.tick - newest;
    return behind > 0 ? behind * facts.period_s : 0;
  }

  /** What is so, in words; once a second what comes. */
  say() {
    const now_ms = performance.now();
    const { figures, window, stream } = this;
    const isLate = stream.state === "live" && this.late_s > LATE_S;
    const isFilling = now_ms - stream.began_ms < FILLS_MS;
    const state = isLate ? (isFilling ? "begins" : "late") : stream.state;
    const isDue = now_ms - figures.since_ms >= RATE_MS;
    if (isDue) {
      const per_s = 1000 / (now_ms - figures.since_ms);
      this.rate = { rows: Math.round((figures.rows - figures.rowsThen) * per_s), frames: Math.round((figures.frames - figures.framesThen) * per_s) };
    }
    if (isDue || figures.rowsThen === undefined) {
      Object.assign(figures, { since_ms: now_ms, rowsThen: figures.rows, framesThen: figures.frames });
      this.happened.update();
    }
    const hasCome = this.buffer.next > 0 && !this.saidRows; // who comes here need not wait for the first rate
    if (!isDue && !hasCome && state === this.said && window.isLive === this.saidLive) return;
    this.said = state;
    this.saidRows = this.buffer.next > 0;
    this.saidLive = window.isLive;
    say(this.status, this.stateWords(state));
    mark(this.element, "data-state", state);
    mark(this.element, "data-paused", !window.isLive);
    say(this.lack, this.lackWords());
  }

  stateWords(state) {
    const words = text.signals.state;
    if (state === "over") return fill(words.over, { reason: this.reason });
    if (state === "lost") return fill(words.lost, { s: Math.floor((performance.now() - this.stream.lost_ms) / 1000) });
    if (state === "late") return fill(words.late, { s: this.late_s.toFixed(0) });
    if (state === "silent") return fill(words.silent, { s: Math.floor(this.stream.silent_s) });
    if (!this.window.isLive) return fill(words.paused, { s: Math.round(this.window.frozen.buffer.last_s - this.window.frozen.buffer.first_s) });
    if (this.buffer.next === 0 || state === "begins") return words.begins;
    return this.rate ? fill(words.live, this.rate) : words.first;
  }

  lackWords() {
    const words = text.signals.state;
    const { missed, skipped } = this.buffer;
    const parts = [missed ? fill(words.missed, { count: missed }) : "", skipped ? fill(words.skipped, { count: skipped }) : ""];
    return parts.filter(Boolean).join("; ");
  }

  showTools() {
    const isLive = this.window.isLive;
    say(this.pauseButton, isLive ? text.signals.pause : text.signals.resume);
    for (const one of this.spans) mark(one, "aria-pressed", String(isLive && Number(one.dataset.span) === this.window.span_s));
    const now = presetOf(this.names);
    show(this.presets.querySelector('[value="own"]'), now === "own");
    this.presets.value = now;
    this.plots.isDirty = true;
  }

  toggle() {
    if (this.window.isLive) this.pause();
    else this.resume();
  }

  pause() {
    this.window.freeze(this.buffer);
    this.showTools();
  }

  resume() {
    this.window.thaw();
    this.plots.clear();
    this.showTools();
  }

  span(span_s) {
    this.window.span_s = span_s;
    this.resume();
  }

  preset(name) {
    if (name in PRESETS) this.choose(PRESETS[name].filter((one) => this.known.has(one)));
  }

  toggleLoop() {
    this.hasLoop = !this.hasLoop;
    mark(this.loopButton, "aria-pressed", String(this.hasLoop));
    show(this.loop.element, this.hasLoop);
    mark(this.element, "data-loop", this.hasLoop);
    this.plots.isDirty = true;
  }

  /** Whoever moves or measures stands still first. */
  still() {
    this.pause();
    this.plots.isDirty = true;
    return !this.window.isLive;
  }

  zoom(factor, x) {
    if (!this.still()) return;
    const { left, width } = this.plots.box;
    this.window.zoom(factor, this.plots.instantAt(x ?? left + width / 2));
  }

  pan(pixels) {
    if (!this.still()) return;
    this.window.pan((pixels / this.plots.box.width) * this.window.frozen.span_s);
  }

  put(name, x) {
    if (!this.still()) return;
    const { left, width } = this.plots.box;
    const at = x ?? left + width / 2;
    if (at >= left && at <= left + width) this.plots.put(name, this.plots.instantAt(at));
  }

  nudge(pixels) {
    const name = this.plots.moved;
    if (this.window.isLive || !name || this.plots.cursors[name] === null) return;
    const by_s = (pixels / this.plots.box.width) * this.window.frozen.span_s;
    const { next } = this.plots;
    this.plots.put(name, this.plots.cursors[name] + by_s);
    this.plots.next = next;
    this.plots.isDirty = true;
  }

  clear() {
    this.plots.clear();
    this.plots.isDirty = true;
  }

  lookAt(one) {
    if (!this.still()) return;
    this.window.centre(one.time_s);
    this.plots.put("a", one.time_s);
  }

  save() {
    if (this.buffer.next === 0) return;
    const { window, names } = this;
    const buffer = window.buffer(this.buffer);
    const pieces = csv(buffer, names, window.ends(this.buffer), this.offset, aboutOf(this.context, this.facts, buffer, names));
    const now = new Date(machineNow() ?? Date.now()).toISOString().replace(/[-:]/g, "").slice(0, 15);
    save(pieces, `signals-${this.context.machine?.serial ?? "machine"}-${now}Z.csv`);
  }

  themeChanged() {
    this.plots.repaint();
    this.loop.repaint();
  }

  unmount() {
    cancelAnimationFrame(this.request);
    removeEventListener("themechange", this.repaint);
    this.scheme.removeEventListener("change", this.repaint);
    this.stream.close();
    this.plots.close();
  }
}

/** Show the view; gives what takes it away. */
export function mount(root, context) {
  let view = null;
  let isGone = false;
  const begin = async () => {
    const [listed] = await Promise.all([context.api.get("/signals/channels"), loadPlotStyle()]);
    if (!isGone) view = new Signals(root, context, listed);
  };
  begin().catch((error) => {
    if (!isGone) root.replaceChildren(make("p", { class: "view-note" }, error.message));
  });
  return () => {
    isGone = true;
    view?.unmount();
  };
}

/** Of the plots' own canvas; the same file that a report holds. */
function loadPlotStyle() {
  const href = "vendor/uPlot.css";
  if (document.querySelector(`link[href="${href}"]`)) return null;
  const sheet = make("link", { rel: "stylesheet", href });
  return new Promise((done) => {
    sheet.addEventListener("load", done);
    sheet.addEventListener("error", done);
    document.head.append(sheet);
  });
}
