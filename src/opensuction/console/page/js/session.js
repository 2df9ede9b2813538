// Who is signed in on this page, as the console says: it is looked at by a timer of its own, for a
// session may be ended, or be another person's, without anything being done on this page.

const NOBODY = { name: null, role: null, is_administrator: false, must_change_password: false, rights: ["stop", "see-bedside", "sign-in"], csrf: null };
const SHOWN = ["name", "role", "is_administrator", "must_change_password", "rights"];
const LOOK_MS = 10000;
const OVER = 401;

export class Session {
  constructor(api) {
    this.api = api;
    this.listeners = new Set();
    this.hasEnded = false; // somebody was signed in, and is not any more without having said so
    this.changes = 0; // under way, from this page
    this.version = 0; // of what is known
    this.isLooking = false;
    this.firstLook = new Promise((done) => { this.endFirstLook = done; }); // until then nobody is known
    this.take(NOBODY);
    api.ondenied = () => this.look();
    setInterval(() => this.look(), LOOK_MS);
    addEventListener("focus", () => this.look());
    document.addEventListener("visibilitychange", () => {
      if (!document.hidden) this.look();
    });
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
    const known = { ...NOBODY, ...told };
    for (const name of SHOWN) this[name] = known[name];
    if (this.name !== null) this.hasEnded = false;
    this.api.csrf = known.csrf;
    this.version += 1;
    for (const fn of this.listeners) fn(this);
  }

  /** Ask the console who is signed in; what it does not answer stays as it is. Uses no session. */
  async look() {
    if (this.isLooking || this.changes > 0) return;
    this.isLooking = true;
    const { version } = this;
    try {
      const told = { ...NOBODY, ...(await this.api.watch("/session")) };
      if (this.changes > 0 || version !== this.version) return; // it says what was before
      if (this.name !== null && told.name === null) this.end();
      else if (SHOWN.some((name) => JSON.stringify(told[name]) !== JSON.stringify(this[name]))) this.take(told);
      else this.api.csrf = told.csrf; // the same person may have signed in anew, in another tab
    } catch {
      // The connection is shown elsewhere.
    } finally {
      this.isLooking = false;
      this.endFirstLook();
    }
  }

  /** Do what makes another session of this one; where that is refused, see whose it is. */
  async change(act) {
    this.changes += 1;
    let isDone = false;
    try {
      const told = await act();
      isDone = true;
      return told;
    } finally {
      this.changes -= 1;
      if (!isDone) this.look();
    }
  }

  async signIn(name, password) {
    this.hasEnded = false;
    this.take(await this.change(() => this.api.post("/session", { name, password })));
  }

  async signOut() {
    try {
      await this.change(() => this.api.remove("/session"));
    } catch (error) {
      if (error.status !== OVER) throw error; // nobody knows that it has ended: the name stays
    }
    this.hasEnded = false;
    this.take(NOBODY);
  }

  async changePassword(present, wanted) {
    this.take(await this.change(() => this.api.put("/session/password", { present, wanted })));
  }

  end() {
    this.hasEnded = true;
    this.take(NOBODY);
  }
}
