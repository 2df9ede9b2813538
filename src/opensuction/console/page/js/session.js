// Who is signed in on this page, and until when.

const NOBODY = { name: null, role: null, is_administrator: false, must_change_password: false, rights: ["stop", "see-bedside", "sign-in"], csrf: null, expires_at: null };
const GRACE_MS = 1500;
const LONGEST_TIMER_MS = 2 ** 31 - 1;

export class Session {
  constructor(api) {
    this.api = api;
    this.listeners = new Set();
    this.hasEnded = false; // somebody was signed in, and is not any more without having said so
    this.timer = null;
    this.take(NOBODY);
    api.onended = (path) => {
      if (this.name !== null && path !== "/session") this.end();
    };
    api.onused = () => this.watch();
  }

  /** Whether the person at this page may do something. */
  may(right) {
    return this.rights.includes(right);
  }

  subscribe(fn) {
    this.listeners.add(fn);
    return () => this.listeners.delete(fn);
  }

  take(told) {
    const { name, role, is_administrator, must_change_password, rights, csrf, expires_at } = { ...NOBODY, ...told };
    Object.assign(this, { name, role, is_administrator, must_change_password, rights, expires_at });
    this.api.csrf = csrf;
    this.idle_ms = expires_at ? Math.max(Date.parse(expires_at) - Date.now(), 0) : null;
    this.watch();
    for (const fn of this.listeners) fn(this);
  }

  /** Ask the console who is signed in. */
  async load() {
    const before = this.name;
    const told = await this.api.get("/session");
    if (before !== null && told.name === null) this.end();
    else if (JSON.stringify(told.rights) !== JSON.stringify(this.rights) || told.name !== before) this.take(told);
    else {
      this.api.csrf = told.csrf ?? this.api.csrf;
      this.idle_ms = told.expires_at ? Math.max(Date.parse(told.expires_at) - Date.now(), 0) : null;
      this.watch();
    }
  }

  /** A session ends when nothing is asked for a while: look then, and say so. */
  watch() {
    clearTimeout(this.timer);
    if (this.name === null || this.idle_ms === null) return;
    const wait_ms = Math.min(this.idle_ms + GRACE_MS, LONGEST_TIMER_MS);
    this.timer = setTimeout(() => this.load().catch(() => {}), wait_ms);
  }

  async signIn(name, password) {
    this.hasEnded = false;
    this.take(await this.api.post("/session", { name, password }));
  }

  async signOut() {
    try {
      await this.api.remove("/session");
    } finally {
      this.hasEnded = false;
      this.take(NOBODY);
    }
  }

  async changePassword(present, wanted) {
    this.take(await this.api.put("/session/password", { present, wanted }));
  }

  end() {
    this.hasEnded = true;
    this.take(NOBODY);
  }
}
