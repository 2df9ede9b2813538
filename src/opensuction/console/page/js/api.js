// The interface of the console, as this page uses it: nothing else is asked of anybody.

import { Order } from "./order.js";

const PREFIX = "api/v1";
const PATIENCE_MS = 15000;
const MOST = 3; // requests at once that change nothing; one change and STOP go beside them

/** A request that was refused (status > 0), or that was not answered (status 0). */
export class Refused extends Error {
  constructor(status, detail, errors = [], wait_s = null) {
    super(detail);
    this.status = status;
    this.detail = detail;
    this.errors = errors; // [{field, detail}]
    this.wait_s = wait_s;
  }

  /** What is wrong with a field; empty where nothing is. */
  of(field) {
    return this.errors.filter((one) => one.field === field).map((one) => one.detail).join(" ");
  }
}

async function refusalOf(answer) {
  let problem = {};
  try {
    problem = await answer.json();
  } catch {
    // An answer without a reason: its status has to do.
  }
  const wait_s = Number(answer.headers.get("Retry-After")) || null;
  const detail = problem.detail || problem.title || `${answer.status} ${answer.statusText}`;
  return new Refused(answer.status, detail, problem.errors || [], wait_s);
}

async function contentOf(answer) {
  if (answer.status === 204) return null;
  const kind = answer.headers.get("Content-Type") || "";
  return kind.includes("json") ? answer.json() : answer.text();
}

export class Api {
  /** words: what is said where no answer came, or where a change was not sent. */
  constructor(words) {
    this.words = words;
    this.order = new Order();
    this.csrf = null;
    this.under_way = 0;
    this.waiting = [];
    this.ondenied = () => {}; // the session may be over, or somebody else's
  }

  /** Ask; the answer's JSON, or null where there is none. Raises Refused. */
  async ask(method, path, body, patience_ms = PATIENCE_MS) {
    return contentOf(await this.fetch(method, path, body, patience_ms));
  }

  /** GET what the page looks at by itself, again and again: a session does not go on for that. */
  async watch(path) {
    return contentOf(await this.look("GET", path, undefined, PATIENCE_MS, { "X-Unattended": "1" }));
  }

  /** POST what changes nothing, as a question is asked: no button waits for it. */
  async query(path, body) {
    return contentOf(await this.look("POST", path, body, PATIENCE_MS));
  }

  /** As `ask`, the answer as it is. A change is sent in the order in which it was pressed. */
  fetch(method, path, body, patience_ms = PATIENCE_MS) {
    if (method === "GET") return this.look(method, path, body, patience_ms);
    const refuse = (why) => new Refused(0, this.words.unsent[why]);
    return this.order.take(() => this.send(method, path, body, patience_ms), refuse);
  }

  /** Wait for what a change needs first, no longer than it waits for those before it. Raises Refused. */
  until(former) {
    return this.order.wait(former, (why) => new Refused(0, this.words.unsent[why]));
  }

  /** Ask for something that changes nothing. Waits where too many others are under way. */
  async look(method, path, body, patience_ms, more = {}) {
    while (this.under_way >= MOST) await new Promise((done) => { this.waiting.push(done); });
    this.under_way += 1;
    try {
      return await this.send(method, path, body, patience_ms, more);
    } finally {
      this.under_way -= 1;
      this.waiting.shift()?.();
    }
  }

  /** STOP: waits for nothing, and what waits is not sent any more. A browser holds six connections:
      two are kept free. */
  async stop(path, body, patience_ms) {
    this.order.stop();
    return (await this.send("POST", path, body, patience_ms)).json();
  }

  async send(method, path, body, patience_ms, more = {}) {
    const headers = { Accept: "application/json", ...more };
    if (body !== undefined) headers["Content-Type"] = "application/json";
    if (method !== "GET" && this.csrf) headers["X-CSRF-Token"] = this.csrf;
    let answer;
    try {
      answer = await fetch(`${PREFIX}${path}`, {
        method,
        headers,
        body: body === undefined ? undefined : JSON.stringify(body),
        credentials: "same-origin",
        cache: "no-store",
        redirect: "error",
        priority: method === "GET" ? "auto" : "high",
        signal: AbortSignal.timeout(patience_ms),
      });
    } catch {
      throw new Refused(0, this.words.unanswered);
    }
    if (answer.ok) return answer;
    const refused = await refusalOf(answer);
    if (refused.status === 401 || refused.status === 403) this.ondenied();
    throw refused;
  }

  get(path) { return this.ask("GET", path); }
  post(path, body) { return this.ask("POST", path, body); }
  put(path, body) { return this.ask("PUT", path, body); }
  remove(path, body) { return this.ask("DELETE", path, body); }
}

/** A key that no other request has. */
export function newKey() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
