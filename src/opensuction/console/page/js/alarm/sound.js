// The sound of alarms, made of the machine's own figures (GET /alarm-signals).
//
// What sounds is what the machine says (its `audible`), or that the machine is not heard any more.

import { after } from "../timer.js";

const RATE_HZ = 22050;
const AHEAD_S = 0.05;

/** Samples of one burst: a raised cosine around tones with harmonics. */
export function burst(signal, rate_hz) {
  const { pulses, edge_s, foot_s, fundamental_hz, harmonics } = signal;
  const length_s = pulses[pulses.length - 1].end_s + 2 * foot_s;
  const samples = new Float32Array(Math.ceil(length_s * rate_hz));
  for (let i = 0; i < samples.length; i += 1) {
    const time_s = i / rate_hz;
    let level = 0;
    for (const pulse of pulses) {
      const inside_s = Math.min(time_s - pulse.start_s, pulse.end_s + 2 * foot_s - time_s);
      const rise = Math.min(Math.max(inside_s / edge_s, 0), 1);
      level += 0.5 * (1 - Math.cos(Math.PI * rise));
    }
    if (level === 0) continue;
    let wave = 0;
    harmonics.forEach((share, order) => {
      wave += share * Math.sin(2 * Math.PI * (order + 1) * fundamental_hz * time_s);
    });
    samples[i] = level * wave;
  }
  return samples;
}

export class Sound {
  constructor() {
    this.signals = {};
    this.buffers = {};
    this.playing = "none";
    this.source = null;
    this.callOff = () => {};
    this.context = null;
    this.onchange = () => {};
    try {
      this.context = new AudioContext();
      this.context.addEventListener("statechange", () => this.onchange());
    } catch {
      this.context = null; // no loudspeaker: told by `state`
    }
    const wake = () => this.wake();
    for (const kind of ["pointerdown", "keydown"]) addEventListener(kind, wake, { capture: true });
  }

  /** Take the figures in; without them nothing sounds. */
  learn(signals) {
    for (const signal of signals) {
      this.signals[signal.priority] = signal;
      if (!this.context) continue;
      const samples = burst(signal, RATE_HZ);
      const buffer = this.context.createBuffer(1, samples.length, RATE_HZ);
      buffer.copyToChannel(samples, 0);
      this.buffers[signal.priority] = buffer;
    }
    const wanted = this.playing;
    this.playing = "none";
    this.play(wanted);
    this.onchange();
  }

  /** "ready", "blocked" (until the page is touched) or "unable". */
  get state() {
    if (!this.context || !("high" in this.buffers)) return "unable";
    return this.context.state === "running" ? "ready" : "blocked";
  }

  wake() {
    if (this.context && this.context.state !== "running") this.context.resume().catch(() => {});
  }

  /** Sound a priority from now on, over and over; "none": nothing. */
  play(priority) {
    if (priority === this.playing) return;
    this.playing = priority;
    this.callOff();
    if (this.source) this.source.stop();
    this.source = null;
    if (priority !== "none") this.repeat();
  }

  /** The reminder that something is shown and makes no sound. */
  remind() {
    if (this.playing === "none" && this.buffers.none) this.begin(this.buffers.none);
  }

  /** Sound a burst once; gives its source, or null where the page may not sound yet. */
  begin(buffer) {
    if (this.context.state !== "running") return null;
    const source = this.context.createBufferSource();
    source.buffer = buffer;
    source.connect(this.context.destination);
    source.start(this.context.currentTime + AHEAD_S);
    return source;
  }

  repeat() {
    const buffer = this.buffers[this.playing];
    if (!buffer) return;
    this.source = this.begin(buffer);
    const again_s = this.context.state === "running" ? this.signals[this.playing].period_s : 0.25;
    this.callOff = after(1000 * again_s, () => this.repeat());
  }
}
