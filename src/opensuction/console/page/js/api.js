// The interface of the console, as this page uses it: nothing else is asked of anybody.

const PREFIX = "api/v1";
const PATIENCE_MS = 15000;
const MOST = 4; // requests at once; STOP goes beside them

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

export class Api {
  /** unanswered: what is said where no answer came. */
  constructor(unanswered) {
    this.unanswered = unanswered;
    this.csrf = null;
    this.under_way = 0;
    this.waiting = [];
    this.onended = () => {};
    this.onused = () => {};
  }

  /** Ask; the answer's JSON, or null where there is none. Raises Refused. */
  async ask(method, path, body, patience_ms = PATIENCE_MS) {
    const answer = await this.fetch(method, path, body, patience_ms);
    if (answer.status === 204) return null;
    const kind = answer.headers.get("Content-Type") || "";
    return kind.includes("json") ? answer.json() : answer.text();
  }

  /** As `ask`, the answer as it is. Waits where too many others are under way. */
  async fetch(method, path, body, patience_ms = PATIENCE_MS) {
    while (this.under_way >= MOST) await new Promise((done) => { this.waiting.push(done); });
    this.under_way += 1;
    try {
      return await this.send(method, path, body, patience_ms);
    } finally {
      this.under_way -= 1;
      this.waiting.shift()?.();
    }
  }

  /** POST without waiting for anything: a browser holds six connections, and two are kept free. */
  async askAtOnce(path, body, patience_ms) {
    return (await this.send("POST", path, body, patience_ms)).json();
  }

  async send(method, path, body, patience_ms) {
    const headers = { Accept: "application/json" };
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
      throw new Refused(0, this.unanswered);
    }
    if (answer.ok) {
      this.onused();
      return answer;
    }
    const refused = await refusalOf(answer);
    if (refused.status === 401) this.onended(path);
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
