// What is there on every view: alarm bar, header, navigation, STOP, notice.

import { AlarmBar } from "./alarm/bar.js";
import { openPassword, openSignIn } from "./account/sign_in.js";
import { deviceAhead, machineNow } from "./clock.js";
import { closeDialog, isOpen } from "./dialog.js";
import { make, mark, say, show } from "./dom.js";
import { CONNECTING, GOOD } from "./live.js";
import { NowPanel } from "./now.js";
import { learnPhases } from "./situation.js";
import { Stop } from "./stop.js";
import { fill, loadText, text } from "./text.js";
import { applyTheme, switchTheme, theme } from "./theme.js";
import { VIEWS, viewOf } from "./views.js";
import { age, clock } from "./words.js";

const MACHINE_MS = 15000; // how often it is asked whose machine this is
const TIME_MS = 500;
const APART_S = 5; // so far this device's clock may be from the machine's
const APART_LOOKS = 6; // so often in a row: a first message may come late

class Shell {
  constructor(root, footer, context) {
    this.root = root;
    this.footer = footer;
    this.context = context;
    this.unmount = () => {};
    this.opening = 0;
    this.looks = 0;
    this.title = text.shell.product;
    this.person = null;
    context.askSignIn = () => openSignIn(context.session);
    context.machineChanged = new Set();
    this.alarm = new AlarmBar(context);
    this.stop = new Stop(context.api, context.live, this.alarm);
    this.now = new NowPanel(context);
    this.build();
    applyTheme((now) => this.showTheme(now));
    context.session.subscribe(() => this.showSession());
    context.live.follow((link) => this.showLink(link));
    addEventListener("hashchange", () => this.open());
    setInterval(() => this.showTime(), TIME_MS);
    this.showSession();
    this.begin();
  }

  build() {
    const words = text.shell;
    this.who = make("p", { class: "who" });
    this.what = make("p", { class: "what" }, words.unknownMachine);
    this.link = make("p", { class: "link", role: "status" });
    this.clock = make("p", { class: "clock" }, words.noTime);
    this.apart = make("p", { class: "clock-apart", role: "status" });
    this.you = make("button", { type: "button", class: "you", onclick: () => openPassword(this.context.session) });
    this.sign = make("button", { type: "button", class: "sign", onclick: () => this.toggleSign() });
    this.theme = make("button", { type: "button", class: "theme", onclick: () => this.showTheme(switchTheme()) });
    this.links = VIEWS.map((view) => make("a", { href: `#/${view.name}`, "data-view": view.name }, words.views[view.name]));
    this.view = make("div", { class: "view", id: "view", tabindex: "-1" });
    this.aside = make("div", { class: "aside-view" });
    this.context.aside = this.aside;
    const header = make("header", { class: "header" }, make("div", { class: "patient" }, this.who, this.what), this.alarm.allow, this.link, this.clock,
      make("div", { class: "account" }, this.you, this.sign, this.theme));
    const navigation = make("nav", { class: "navigation", "aria-label": words.navigation, "data-covered": "" }, this.links);
    const stage = make("main", { class: "stage" }, make("div", { class: "stage-scroll", "data-covered": "" }, this.view));
    const skip = make("a", { class: "skip", href: "#view", onclick: (event) => this.skipTo(event) }, words.skip);
    this.root.replaceChildren(skip, this.alarm.element, this.alarm.list.element, header, this.apart, navigation, stage,
      make("aside", { class: "aside", "aria-label": words.stop.label }, this.aside, this.now.element, this.stop.element),
      this.stop.failure);
  }

  skipTo(event) {
    event.preventDefault();
    this.view.focus();
  }

  async begin() {
    this.refreshMachine();
    await this.context.session.look();
    this.showSession();
    this.open();
  }

  async refreshMachine() {
    try {
      const machine = await this.context.api.get("/machine");
      if (JSON.stringify(machine) !== JSON.stringify(this.context.machine)) {
        this.context.machine = machine;
        learnPhases(machine.phases);
        this.showMachine(machine);
        for (const fn of this.context.machineChanged) fn(machine);
      }
    } catch {
      // The connection is shown elsewhere; what was known of the machine stays true.
    }
    clearTimeout(this.again);
    this.again = setTimeout(() => this.refreshMachine(), this.context.machine ? MACHINE_MS : 1500);
  }

  showMachine(machine) {
    const words = text.shell;
    const { patient } = machine;
    const old = patient?.age ? ` (${words.ages[patient.age] || patient.age})` : "";
    const who = patient?.pseudonym ? fill(words.patient, { pseudonym: patient.pseudonym }) + old : words.bench;
    say(this.who, who);
    this.showWhat();
    const lacking = Object.entries(words.capabilities).filter(([name]) => machine.capabilities?.[name] === false);
    const lacks = lacking.length ? fill(words.lacks, { what: lacking.map(([, word]) => word).join(", ") }) : "";
    const notice = machine.is_twin === false ? words.noticePlain : words.notice;
    say(this.footer, [notice, lacks].filter(Boolean).join(" "));
  }

  /** Protocol, machine, and how long the catheter may be used. */
  showWhat() {
    const { machine, live } = this.context;
    if (!machine) return;
    const words = text.shell;
    const protocol = machine.protocol?.name ? fill(words.protocol, { name: machine.protocol.name }) : "";
    const life_s = live.known?.catheter_left_s ?? null;
    const life = life_s === null ? "" : life_s > 0 ? fill(words.catheterLeft, { left: age(life_s) }) : words.catheterOver;
    say(this.what, [protocol, machine.serial, life].filter(Boolean).join(" · "));
  }

  showLink(link) {
    this.showWhat();
    const kind = link.hasFailed ? "failed" : link.kind;
    const words = text.shell.link[kind];
    mark(this.link, "data-kind", kind);
    mark(document.documentElement, "data-link", kind);
    say(this.link, link.kind === GOOD || link.age_s === null ? words : `${words}, ${age(link.age_s)}`);
    this.showTitle();
  }

  /** All that a hidden tab shows is its title. */
  showTitle() {
    const { kind, hasFailed } = this.context.live.link;
    const isHeard = (kind === GOOD || kind === CONNECTING) && !hasFailed;
    const title = isHeard ? this.title : `${text.shell.link[hasFailed ? "failed" : kind]} · ${this.title}`;
    if (document.title !== title) document.title = title;
  }

  /** The machine's time, and that this device shows another one, once that has lasted for a while. */
  showTime() {
    const words = text.shell.apart;
    const now_ms = machineNow();
    say(this.clock, now_ms === null ? text.shell.noTime : clock(now_ms, true));
    const ahead_s = deviceAhead();
    this.looks = Math.abs(ahead_s) > APART_S ? this.looks + 1 : 0;
    const told = fill(ahead_s > 0 ? words.ahead : words.behind, { by: age(Math.round(Math.abs(ahead_s))) });
    say(this.apart, this.looks < APART_LOOKS ? "" : told);
  }

  showTheme(now = theme()) {
    const words = now === "dark" ? text.shell.theme.toLight : text.shell.theme.toDark;
    say(this.theme, now === "dark" ? "\u2600" : "\u263e");
    mark(this.theme, "aria-label", words);
    mark(this.theme, "title", words);
  }

  showSession() {
    const words = text.shell;
    const { session } = this.context;
    const isKnown = session.name !== null;
    show(this.you, isKnown);
    if (isKnown) {
      const roles = [words.roles[session.role] || session.role, session.is_administrator ? words.administrator : null];
      say(this.you, fill(words.you, { name: session.name, role: roles.filter(Boolean).join(", ") }));
      mark(this.you, "title", text.account.password.open);
    }
    say(this.sign, isKnown ? words.signOut : words.signIn);
    if (this.person !== null && session.name !== this.person) closeDialog(); // it was that person's
    this.person = session.name;
    if (session.must_change_password && !isOpen()) openPassword(session);
    if (session.hasEnded && !isOpen()) openSignIn(session);
    if (this.shown && this.shown !== this.sessionKey()) this.open();
  }

  sessionKey() {
    const { name, rights } = this.context.session;
    return JSON.stringify([name, rights]);
  }

  async toggleSign() {
    const { session } = this.context;
    if (session.name === null) {
      openSignIn(session);
      return;
    }
    const hadFocus = document.activeElement === this.sign;
    this.sign.disabled = true; // a second click before the answer would sign out once more, instead of in
    await session.signOut().catch(() => {});
    this.sign.disabled = false;
    if (hadFocus) this.sign.focus(); // a disabled button loses it, and a keyboard its place
  }

  /** Show the view that the address names. */
  async open() {
    const view = viewOf(location.hash);
    const title = text.shell.views[view.name];
    this.opening += 1;
    const mine = this.opening;
    this.unmount();
    this.unmount = () => {};
    this.shown = this.sessionKey();
    for (const link of this.links) mark(link, "aria-current", link.dataset.view === view.name ? "page" : null);
    mark(this.root, "data-view", view.name);
    this.title = `${title} - ${text.shell.product}`;
    this.showTitle();
    this.aside.replaceChildren();
    show(this.now.element, view.name !== "bedside");
    if (!this.context.session.may(view.right)) {
      this.refuse(title);
      return;
    }
    this.view.replaceChildren(make("p", { class: "view-note" }, fill(text.shell.loading, { view: title })));
    try {
      if (view.isOwn) await Promise.all([loadText(view.name), loadStyle(view.name)]);
      const module = await view.load();
      if (mine !== this.opening) return;
      this.view.replaceChildren();
      this.unmount = module.mount(this.view, this.context) || (() => {});
    } catch (error) {
      if (mine !== this.opening) return;
      console.error(error);
      this.view.replaceChildren(
        make("p", { class: "view-note" }, fill(text.shell.broken, { detail: String(error.message || error) })),
        make("button", { type: "button", onclick: () => this.open() }, text.shell.again),
      );
    }
  }

  refuse(title) {
    const { session } = this.context;
    const isKnown = session.name !== null;
    const role = text.shell.roles[session.role] || session.role;
    const words = isKnown ? fill(text.shell.needsRight, { view: title, role }) : fill(text.shell.needsSignIn, { view: title });
    const button = isKnown ? null : make("button", { type: "button", class: "primary", onclick: () => openSignIn(session) }, text.shell.signIn);
    this.view.replaceChildren(make("h1", {}, title), make("p", { class: "view-note" }, words), ...(button ? [button] : []));
  }
}

const styles = new Map();

/** Take a view's styles in, once. A view without any is shown without. */
function loadStyle(name) {
  if (!styles.has(name)) {
    const sheet = make("link", { rel: "stylesheet", href: `css/${name}.css` });
    styles.set(name, new Promise((done) => {
      sheet.addEventListener("load", done);
      sheet.addEventListener("error", done);
    }));
    document.head.append(sheet);
  }
  return styles.get(name);
}

/** Build the shell. */
export function mountShell(root, footer, context) {
  return new Shell(root, footer, context);
}
