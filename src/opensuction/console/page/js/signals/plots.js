// All plots one below the other, over the same time, with cursors, marks and values.

import { make, say, show } from "../dom.js";
import { fill, text } from "../text.js";
import { Band } from "./band.js";
import { listen } from "./pointer.js";
import { Strip, enlarged } from "./strip.js";

const LEAST_PX = 84;
const MOST_PX = 260;
const BASE_PX = 26; // of a legend: its unit,
const LINE_PX = 36; // and each of its lines
const BELOW_PX = 90; // what stands below the plots
const TELL_MS = 100; // numbers that change faster cannot be read

export class Plots {
  /** about: {window, marks, live(), offset(), act}; see `listen`. */
  constructor(about) {
    this.about = about;
    this.band = new Band();
    this.strips = [];
    this.cursors = { a: null, b: null }; // instants, by the machine's clock
    this.next = "a"; // the one that a tap puts
    this.lines = { a: this.lineOf("a"), b: this.lineOf("b") };
    this.between = make("p", { class: "cursors-between", role: "status" });
    this.place = make("div", { class: "strips" });
    this.area = make("div", { class: "strips-area", tabindex: "0", role: "group", "aria-label": text.signals.plots }, this.band.canvas, this.place, this.lines.a, this.lines.b);
    this.element = make("div", { class: "plots" }, this.area, this.between);
    this.told_ms = 0;
    listen(this.area, about.act);
    this.watch = new ResizeObserver(() => this.resize());
    this.watch.observe(this.area);
  }

  lineOf(name) {
    return make("div", { class: `cursor cursor-${name}`, hidden: true, "aria-hidden": "true" }, make("span", {}, name.toUpperCase()));
  }

  /** Other channels: [channel, ...] as the buffer has them; drawn are those that were chosen. */
  choose(buffer, names) {
    for (const strip of this.strips) strip.close();
    const units = new Map();
    names.forEach((name, i) => {
      const place = buffer.channels.findIndex((one) => one.name === name);
      const channel = buffer.channels[place];
      if (!units.has(channel.unit)) units.set(channel.unit, []);
      units.get(channel.unit).push({ place, channel, colour: i % 8 });
    });
    const { window, marks, live, offset } = this.about;
    const shown = () => marks.between(...window.ends(live()));
    this.strips = [...units].map(([unit, lines]) => new Strip(unit, lines, { height: LEAST_PX, offset, marks: shown }));
    this.place.replaceChildren(...this.strips.map((strip) => strip.element));
    this.resize();
  }

  resize() {
    const width = this.strips[0]?.plotted.clientWidth;
    if (!width) return;
    const heights = this.strips.map((strip) => (BASE_PX + LINE_PX * strip.lines.length) * enlarged());
    const needed = heights.reduce((sum, one) => sum + Math.max(one, LEAST_PX), 0);
    // What is left of the view's height is shared out.
    const more = Math.max((this.room - needed) / this.strips.length, 0);
    for (const [i, strip] of this.strips.entries()) {
      strip.options.height = Math.floor(Math.min(Math.max(heights[i], LEAST_PX) + more, MOST_PX * enlarged()));
      strip.build(width);
    }
    this.isDirty = true;
  }

  /** Height that the plots may take without scrolling. */
  get room() {
    const stage = this.element.closest(".stage") ?? document.body;
    return stage.clientHeight - this.area.offsetTop - this.band.canvas.offsetHeight - BELOW_PX * enlarged();
  }

  repaint() {
    this.band.repaint();
    this.resize();
  }

  get box() {
    return this.strips[0].box;
  }

  /** The instant at a place of the area. */
  instantAt(x) {
    const [from_s, to_s] = this.about.window.ends(this.about.live());
    return from_s + ((x - this.box.left) / this.box.width) * (to_s - from_s);
  }

  put(name, instant_s) {
    this.cursors[name] = instant_s;
    this.next = name === "a" ? "b" : "a";
    this.moved = name;
    this.told_ms = 0;
  }

  clear() {
    this.cursors = { a: null, b: null };
    this.next = "a";
    this.told_ms = 0;
  }

  draw() {
    const { window, marks, live } = this.about;
    const buffer = window.buffer(live());
    const [from_s, to_s] = window.ends(live());
    for (const strip of this.strips) strip.draw(buffer, from_s, to_s);
    this.band.draw(marks, this.box, [from_s, to_s], this.about.offset());
    this.drawCursors(from_s, to_s);
    if (performance.now() - this.told_ms > TELL_MS) this.tell(buffer, to_s);
  }

  drawCursors(from_s, to_s) {
    for (const name of ["a", "b"]) {
      const at_s = this.cursors[name];
      const isSeen = at_s !== null && at_s >= from_s && at_s <= to_s;
      show(this.lines[name], isSeen);
      if (isSeen) this.lines[name].style.transform = `translateX(${this.box.left + ((at_s - from_s) / (to_s - from_s)) * this.box.width}px)`;
    }
  }

  tell(buffer, to_s) {
    this.told_ms = performance.now();
    const { a, b } = this.cursors;
    const rows = { a: a === null ? null : buffer.nearest(a), b: b === null ? null : buffer.nearest(b) };
    const row = buffer.next === 0 ? null : Math.max(Math.min(buffer.find(to_s), buffer.next - 1), buffer.first);
    for (const strip of this.strips) strip.tell(buffer, row, rows);
    const isBoth = rows.a !== null && rows.b !== null;
    const at = (one) => buffer.time_s[one & buffer.mask];
    say(this.between, isBoth ? fill(text.signals.between, { s: (at(rows.b) - at(rows.a)).toFixed(3).replace("-", "−") }) : "");
  }

  close() {
    this.watch.disconnect();
    for (const strip of this.strips) strip.close();
  }
}
