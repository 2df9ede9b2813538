// The connection: rows as they come, and words beside them; it comes back by itself.

import { readFrame } from "./frame.js";

const PAST_S = 9;
const BACK_OFF_MS = [250, 500, 1000, 2000, 4000];
const SILENT_MS = 1500; // rows come 40 times a second, as long as the control process writes any
const OVER = 1008; // signed out meanwhile, or no longer allowed

export class Stream {
  /** take: {frame(frame), event(event), source(source), ended(reason)}. */
  constructor(names, take) {
    this.names = names;
    this.take = take;
    this.tries = 0;
    this.heard_ms = performance.now();
    this.lost_ms = null; // since when there is no connection
    this.isOver = false;
    this.connect(PAST_S);
  }

  /** What is to be said of it: "live", "silent" (connected, no rows), "lost" or "over". */
  get state() {
    if (this.isOver) return "over";
    if (this.lost_ms !== null) return "lost";
    return performance.now() - this.heard_ms > SILENT_MS ? "silent" : "live";
  }

  get silent_s() {
    return (performance.now() - this.heard_ms) / 1000;
  }

  /** more: of the address. */
  connect(past_s, more = {}) {
    clearTimeout(this.retry);
    const url = new URL("api/v1/signals", document.baseURI);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    url.searchParams.set("channels", this.names.join(","));
    url.searchParams.set("past_s", past_s.toFixed(1));
    for (const [name, value] of Object.entries(more)) url.searchParams.set(name, value);
    const socket = new WebSocket(url);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.began_ms = performance.now();
    socket.addEventListener("message", (event) => this.hear(socket, event.data));
    socket.addEventListener("close", (event) => this.drop(socket, event));
  }

  hear(socket, data) {
    if (socket !== this.socket) return;
    this.tries = 0;
    this.lost_ms = null;
    if (typeof data !== "string") {
      const frame = readFrame(data);
      if (frame === null) return;
      this.heard_ms = performance.now();
      this.take.frame(frame);
      return;
    }
    const words = JSON.parse(data);
    if (words.kind === "source") this.take.source(words);
    else if (words.kind === "event") this.take.event(words);
  }

  drop(socket, event) {
    if (socket !== this.socket) return;
    this.socket = null;
    if (event.code === OVER) {
      this.isOver = true;
      this.take.ended(event.reason);
      return;
    }
    if (this.lost_ms === null) this.lost_ms = performance.now();
    const wait_ms = BACK_OFF_MS[Math.min(this.tries, BACK_OFF_MS.length - 1)];
    this.tries += 1;
    // What was missed meanwhile is asked for again, as far as the machine's ring has it.
    // Nobody has asked for it: a session does not go on for that.
    this.retry = setTimeout(() => this.connect(PAST_S, { unattended: "1" }), wait_ms);
  }

  close() {
    clearTimeout(this.retry);
    const { socket } = this;
    this.socket = null;
    if (socket) socket.close();
  }
}
