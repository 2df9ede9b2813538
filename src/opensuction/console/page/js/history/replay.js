// A recording played through the controller again, and what came of it.

import { make } from "../dom.js";
import { fill, text } from "../text.js";
import { refusal } from "./parts.js";

const AGAIN_MS = 1500;

const shown = (value) => (value === null ? text.history.replay.notFinite : String(value));

export class Replay {
  constructor(api, id) {
    this.api = api;
    this.path = `/cycles/${encodeURIComponent(id)}/replay`;
    this.body = make("div", { class: "replay-body" });
    this.element = make("section", { class: "replay", "aria-labelledby": "replay-title" },
      make("h2", { id: "replay-title" }, text.history.replay.title), make("p", {}, text.history.replay.say), this.body);
    this.isWanted = true;
    this.look();
  }

  close() {
    this.isWanted = false;
    clearTimeout(this.timer);
  }

  async look() {
    await this.take(() => this.api.watch(this.path));
  }

  async take(ask) {
    try {
      this.show(await ask());
    } catch (error) {
      if (this.isWanted) this.body.replaceChildren(refusal(error, () => this.look()));
    }
  }

  show(found) {
    if (!this.isWanted) return;
    const words = text.history.replay;
    clearTimeout(this.timer);
    if (found.state === "running") {
      this.body.replaceChildren(make("p", { role: "status" }, words.running));
      this.timer = setTimeout(() => this.look(), AGAIN_MS);
      return;
    }
    if (found.state === "done") {
      this.body.replaceChildren(...verdict(found.verdict));
      return;
    }
    const begin = make("button", { type: "button", onclick: () => this.take(() => this.api.query(this.path)) }, words.begin);
    const failed = found.failure ? [make("p", { class: "verdict bad", role: "status" }, fill(words.failed, { detail: found.failure }))] : [];
    this.body.replaceChildren(...failed, begin);
  }
}

function verdict(found) {
  const words = text.history.replay;
  const kind = found.identical ? "identical" : found.equivalent ? "equivalent" : "different";
  const said = fill(words[kind], { ticks: found.ticks, differing: found.differing_ticks });
  const parts = [make("p", { class: `verdict ${found.is_good ? "good" : "bad"}`, role: "status" }, `${found.is_good ? "\u2713" : "\u2715"} ${said}`)];
  const first = found.first_difference;
  if (first) {
    const facts = [[words.tick, first.tick], [words.time, `${first.time_s.toFixed(3)} s`], [words.field, make("code", {}, first.field)], [words.recorded, shown(first.recorded)], [words.replayed, shown(first.replayed)]];
    parts.push(make("h3", {}, words.first), make("dl", { class: "facts" }, facts.map(([name, value]) => make("div", {}, make("dt", {}, name), make("dd", {}, typeof value === "number" ? String(value) : value)))));
  }
  const notes = [...found.notes];
  if (found.gaps) notes.push(fill(words.gaps, found));
  if (found.damaged) notes.push(words.damaged);
  else if (!found.whole) notes.push(words.notWhole);
  if (notes.length) parts.push(make("ul", {}, notes.map((note) => make("li", {}, note))));
  return parts;
}
