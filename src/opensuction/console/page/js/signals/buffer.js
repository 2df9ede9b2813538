// The last rows of all channels, in arrays that are written round and round.

const ROWS = 1 << 17; // 131 s at 1 kHz
const HOLE_PERIODS = 20; // a hole in time that is a break in the line: missed ticks are none

export class Buffer {
  constructor(channels, rows = ROWS) {
    this.rows = rows;
    this.mask = rows - 1;
    this.channels = channels; // [{name, title, unit, ...}]
    this.time_s = new Float64Array(rows);
    this.tick = new Float64Array(rows);
    this.breaks = new Uint8Array(rows); // 1: no line comes from the row before
    this.values = channels.map(() => new Float32Array(rows));
    this.first = 0; // number of the oldest row that is kept
    this.next = 0; // number of the row that is written next
    this.source = 0;
    this.received = 0;
    this.missed = 0; // rows that this page has not got
    this.skipped = 0; // ticks that the control process has missed itself
  }

  get last_s() {
    return this.next === 0 ? null : this.time_s[(this.next - 1) & this.mask];
  }

  get first_s() {
    return this.next === 0 ? null : this.time_s[this.first & this.mask];
  }

  /** Take a frame in; rows that are here already are left out. */
  push(frame) {
    const { time_s, tick, breaks, mask } = this;
    const isOther = frame.source !== this.source;
    let last_s = this.last_s ?? -Infinity;
    this.source = frame.source;
    let isBroken = isOther || frame.missed > 0;
    let taken = 0;
    for (let i = 0; i < frame.rows; i += 1) {
      const now_s = frame.time_s + frame.steps[i] * frame.period_s;
      if (now_s <= last_s + 0.5 * frame.period_s) continue;
      const periods = (now_s - last_s) / frame.period_s;
      if (taken === 0 && !isBroken && periods > HOLE_PERIODS) isBroken = true;
      if (taken > 0 && periods > 1.5) this.skipped += Math.round(periods) - 1;
      const at = this.next & mask;
      time_s[at] = now_s;
      tick[at] = frame.tick + i;
      breaks[at] = (taken === 0 && isBroken) || periods > HOLE_PERIODS ? 1 : 0;
      for (let c = 0; c < this.values.length; c += 1) this.values[c][at] = frame.values[c][i];
      this.next += 1;
      taken += 1;
      last_s = now_s;
    }
    if (taken > 0) this.missed += frame.missed;
    this.received += taken;
    if (this.next - this.first > this.rows) this.first = this.next - this.rows;
    return taken;
  }

  /** Number of the first row at or after an instant. */
  find(instant_s) {
    let low = this.first;
    let high = this.next;
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (this.time_s[middle & this.mask] < instant_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The row nearest to an instant; null where there is none within a few periods. */
  nearest(instant_s) {
    const after = this.find(instant_s);
    const off = (row) => Math.abs(this.time_s[row & this.mask] - instant_s);
    const found = [after - 1, after].filter((row) => row >= this.first && row < this.next);
    found.sort((one, other) => off(one) - off(other));
    return found.length && off(found[0]) < 0.02 ? found[0] : null;
  }

  value(channel, row) {
    return this.values[channel][row & this.mask];
  }

  /** The same as it is now, for a picture that stands still while rows go on coming. */
  copy() {
    const other = new Buffer([], 1);
    Object.assign(other, this);
    other.time_s = this.time_s.slice();
    other.tick = this.tick.slice();
    other.breaks = this.breaks.slice();
    other.values = this.values.map((values) => values.slice());
    return other;
  }
}
