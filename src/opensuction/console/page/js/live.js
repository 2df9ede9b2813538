// The machine's newest state, 20 times a second, and whether it can be believed.

import { hearTime } from "./clock.js";
import { after, every } from "./timer.js";

const SILENT_MS = 1200; // without a word for so long, the connection is lost (shown within 2 s)
const STALE_S = 1.0; // what the control wrote last is older than this: it does not answer
const LOOK_MS = 200;
const BACK_OFF_MS = [250, 500, 1000, 2000, 4000];

export const GOOD = "good";
export const CONNECTING = "connecting";
export const LOST = "lost";
export const SILENT = "silent"; // the console answers, the machine's control does not

/** Call all, though some of them fail; whether one did. */
function callAll(functions, word) {
  let hasFailed = false;
  for (const fn of functions) {
    try {
      fn(word);
    } catch (error) {
      hasFailed = true;
      reportError(error);
    }
  }
  return hasFailed;
}

export class Live {
  constructor() {
    this.state = null; // the newest
    this.known = null; // the newest in which the machine's control said something
    this.link = { kind: CONNECTING, age_s: null, hasFailed: false };
    this.hasFailed = false; // what the newest state says could not be shown
    this.listeners = new Set();
    this.followers = new Set();
    this.heard_ms = performance.now();
    this.tries = 0;
    this.socket = null;
    this.retry = null; // what calls the next try off
    every(LOOK_MS, () => this.look());
    addEventListener("online", () => this.hurry());
    document.addEventListener("visibilitychange", () => {
      if (!document.hidden) this.hurry();
    });
    this.connect();
  }

  /** Call fn(state) with each new state, and now with the last; gives what ends it. */
  subscribe(fn) {
    this.listeners.add(fn);
    if (this.state) this.hasFailed = callAll([fn], this.state) || this.hasFailed;
    return () => this.listeners.delete(fn);
  }

  /**
   * Call fn(link) some times a second; gives what ends it.
   * link: {kind, age_s, hasFailed}; it has failed where it is good and the newest is not shown.
   */
  follow(fn) {
    this.followers.add(fn);
    callAll([fn], this.link);
    return () => this.followers.delete(fn);
  }

  /** Whether what is shown is what the machine does now. */
  get isLive() {
    return this.link.kind === GOOD && !this.link.hasFailed;
  }

  connect() {
    this.retry?.();
    this.retry = null;
    const url = new URL("api/v1/live", document.baseURI);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(url);
    this.socket = socket;
    this.opened_ms = performance.now();
    socket.addEventListener("message", (event) => this.hear(socket, event.data));
    socket.addEventListener("close", () => this.drop(socket));
    socket.addEventListener("error", () => this.drop(socket));
  }

  hear(socket, words) {
    if (socket !== this.socket) return;
    let state;
    try {
      state = JSON.parse(words);
    } catch {
      return; // no state: as good as silence
    }
    this.heard_ms = performance.now();
    this.tries = 0;
    hearTime(state);
    this.state = state;
    if (state.connected) this.known = state;
    this.look();
    const hasFailed = callAll(this.listeners, state);
    if (hasFailed === this.hasFailed) return;
    this.hasFailed = hasFailed;
    this.look(); // what could not be shown anew must not pass for what is now
  }

  /** Let go of a connection and try anew after a while that grows. */
  drop(socket) {
    if (socket !== this.socket) return;
    this.socket = null;
    socket.close();
    const wait_ms = BACK_OFF_MS[Math.min(this.tries, BACK_OFF_MS.length - 1)];
    this.tries += 1;
    this.retry = after(wait_ms * (0.8 + 0.4 * Math.random()), () => this.connect());
  }

  hurry() {
    if (this.retry !== null) this.connect();
  }

  look() {
    const now_ms = performance.now();
    const silent_ms = now_ms - this.heard_ms;
    // One that is open but says nothing is as dead as one that is closed.
    if (this.socket && silent_ms > SILENT_MS && now_ms - this.opened_ms > 2 * SILENT_MS) {
      this.drop(this.socket);
    }
    const link = this.judge(silent_ms);
    this.link = { ...link, hasFailed: link.kind === GOOD && this.hasFailed };
    callAll(this.followers, this.link);
  }

  judge(silent_ms) {
    const told_s = this.state?.age_s ?? null;
    const age_s = told_s === null ? null : told_s + silent_ms / 1000;
    if (silent_ms > SILENT_MS) return { kind: LOST, age_s };
    if (this.state === null) return { kind: CONNECTING, age_s };
    if (!this.state.connected || told_s === null || told_s > STALE_S) return { kind: SILENT, age_s };
    // Stale by the silence alone: the control was answering when the console was last heard.
    return { kind: age_s > STALE_S ? LOST : GOOD, age_s };
  }
}
