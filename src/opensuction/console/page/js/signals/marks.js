// What happened, in the order of the machine's clock.

const MOST = 400;

export class Marks {
  constructor() {
    this.all = []; // [{time_s, what, name, detail, sentence, priority}]
    this.changes = 0;
  }

  /** Take one in; what is so already is left out: a stream that begins anew says it once more. */
  add(one) {
    let at = this.all.length;
    while (at > 0 && this.all[at - 1].time_s > one.time_s) at -= 1;
    if (this.isKnown(one, at)) return false;
    this.all.splice(at, 0, one);
    if (this.all.length > MOST) this.all.shift();
    this.changes += 1;
    return true;
  }

  isKnown(one, at) {
    const isSame = (other) => other.what === one.what && (one.what === "phase" || other.name === one.name);
    for (let i = at - 1; i >= 0; i -= 1) {
      const other = this.all[i];
      if (other.what === "source" && one.what === "phase") return false;
      if (!isSame(other)) continue;
      if (other.time_s === one.time_s) return other.name === one.name && other.detail === one.detail;
      if (one.what === "phase") return other.name === one.name;
      if (one.what === "alarm") return other.detail === one.detail;
      return false;
    }
    return false;
  }

  between(from_s, to_s) {
    return this.all.filter((one) => one.time_s >= from_s && one.time_s <= to_s);
  }

  /** Phases with beginning and end, as far as they reach between two instants. */
  phases(from_s, to_s) {
    const found = [];
    for (const one of this.all) {
      const isBreak = one.what === "source";
      if (one.what !== "phase" && !isBreak) continue;
      if (found.length && found[found.length - 1].to_s === null) found[found.length - 1].to_s = one.until_s ?? one.time_s;
      if (!isBreak) found.push({ name: one.name, from_s: one.time_s, to_s: null });
    }
    return found
      .map((one) => ({ ...one, to_s: one.to_s ?? Infinity }))
      .filter((one) => one.to_s > from_s && one.from_s < to_s);
  }
}
