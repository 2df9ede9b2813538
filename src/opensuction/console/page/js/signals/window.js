// Which time is seen: the last seconds as they come, or a stretch that stands still.

export const SPANS_S = [5, 10, 30, 60];
const LEAST_S = 0.02;
const MOST_S = 120;

export class Window {
  constructor() {
    this.span_s = 10;
    this.frozen = null; // {buffer, to_s, span_s}
  }

  get isLive() {
    return this.frozen === null;
  }

  /** The rows that are seen. */
  buffer(live) {
    return this.frozen?.buffer ?? live;
  }

  /** Its ends, by the machine's clock. */
  ends(live) {
    if (this.frozen) return [this.frozen.to_s - this.frozen.span_s, this.frozen.to_s];
    const to_s = live.last_s ?? 0;
    return [to_s - this.span_s, to_s];
  }

  /** Stand still. Rows go on being collected beside. */
  freeze(live) {
    if (this.frozen || live.next === 0) return;
    this.frozen = { buffer: live.copy(), to_s: live.last_s, span_s: this.span_s };
  }

  thaw() {
    this.frozen = null;
  }

  /** Zoom about an instant; what stands still only. */
  zoom(factor, about_s) {
    const { frozen } = this;
    const span_s = Math.min(Math.max(frozen.span_s * factor, LEAST_S), MOST_S);
    const share = (frozen.to_s - about_s) / frozen.span_s;
    frozen.span_s = span_s;
    frozen.to_s = about_s + share * span_s;
    this.keepInside();
  }

  pan(seconds) {
    this.frozen.to_s += seconds;
    this.keepInside();
  }

  /** Show an instant in the middle. */
  centre(instant_s) {
    this.frozen.to_s = instant_s + this.frozen.span_s / 2;
    this.keepInside();
  }

  /** Some of what was collected is always seen. */
  keepInside() {
    const { buffer, span_s } = this.frozen;
    const latest_s = buffer.last_s + 0.5 * span_s;
    const earliest_s = buffer.first_s + 0.5 * span_s;
    this.frozen.to_s = Math.max(Math.min(this.frozen.to_s, latest_s), Math.min(earliest_s, latest_s));
  }
}
