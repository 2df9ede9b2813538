// The protocol: a form of what is in force, the planner's word on each draft, and its setting.

import { newKey } from "../api.js";
import { oneLine, openDialog } from "../dialog.js";
import { make, mark, say, show } from "../dom.js";
import { fill, text } from "../text.js";
import { arithmetic } from "./arithmetic.js";
import { numberField } from "./number_field.js";
import { answerLine, shown, tried, whyNotMe, whyNotNow } from "./part.js";

const WAIT_MS = 250;
const GROUPS = {
  depth: ["travel_mm", "backoff_mm"],
  motion: ["insertion_mm_per_s", "withdrawal_mm_per_s"],
  suction: ["vacuum_mmhg", "dwell_s", "nothing_comes_s"],
  limits: ["cap_mm", "contact_from_mm", "negative_pressure_budget_s", "in_airway_budget_s"],
};
const BY_CONTACT = new Set(["contact_from_mm", "backoff_mm"]);

let kept = null; // what somebody has typed and not set: {version, approach, carina, values, name, reason}

class Protocol {
  constructor(root, context, told, guidelines) {
    this.root = root;
    this.context = context;
    this.told = told;
    this.guidelines = guidelines;
    this.asked = 0;
    this.build();
    if (kept) this.restore();
    else this.reset();
    this.unsubscribe = context.live.subscribe(() => this.showWhy());
    this.unfollow = context.live.follow(() => this.showWhy());
  }

  build() {
    const words = text.setup.protocol;
    const limits = this.guidelines.find((one) => one.is_patients)?.limits || [];
    const changed = () => this.changed();
    this.fields = this.told.fields.map((field) => {
      const found = limits.find((one) => one.name === field.guideline);
      const limit = found ? { limit: shown(found.limit), unit: field.unit, source: found.source } : null;
      return numberField(field, limit, changed);
    });
    this.answer = answerLine();
    this.plan = arithmetic();
    this.why = make("p", { class: "setup-why", role: "status" });
    this.changesLine = make("p", { class: "changes" });
    this.needs = make("p", { class: "needs" });
    this.wrong = make("p", { class: "form-refused", role: "alert" });
    this.newer = make("div", { class: "newer", role: "alert", hidden: true });
    this.reason = make("textarea", { id: "draft-reason", rows: 2, maxlength: 500, "aria-describedby": "draft-reason-wrong draft-reason-hint", oninput: changed });
    this.reasonWrong = make("span", { class: "field-wrong", id: "draft-reason-wrong" });
    this.reasonPlace = make("div", { class: "field", hidden: true },
      make("label", { class: "field-label", for: "draft-reason" }, text.setup.reason), this.reason, this.reasonWrong,
      make("span", { class: "field-hint", id: "draft-reason-hint" }, text.setup.reasonHint));
    this.set = make("button", { type: "submit", class: "primary set" }, words.set);
    this.discard = make("button", { type: "button", onclick: () => this.reset() }, words.discard);
    this.approach = {};
    for (const name of ["travel", "contact"]) {
      this.approach[name] = make("input", { type: "radio", name: "approach", value: name, id: `approach-${name}`, onchange: () => this.approached() });
    }
    this.form = make("form", { class: "protocol", novalidate: true, onsubmit: (event) => this.save(event) },
      make("div", { class: "protocol-fields" }, this.head(words), this.choices(words),
        Object.entries(GROUPS).map(([name, fields]) => this.group(name, fields))),
      make("div", { class: "protocol-plan" }, make("h2", {}, words.plan), this.plan.sentence,
        this.newer, this.changesLine, this.needs, this.reasonPlace, this.wrong, this.why,
        make("div", { class: "row" }, this.set, this.discard), this.answer.element, this.plan.element));
    this.root.replaceChildren(this.form);
  }

  head(words) {
    const told = this.told;
    this.inForce = make("h2", {}, fill(words.inForce, { name: told.name, approach: text.setup.approaches[told.approach] }));
    return make("div", { class: "protocol-head" }, this.inForce,
      make("button", { type: "button", onclick: () => this.openSources() }, words.sources),
      make("p", { class: "soft" }, fill(words.carina, { mm: shown(told.carina_mm), by: told.taught_by }), " ",
        fill(words.model, { by: told.calibrated_by })),
      told.is_teaching ? make("p", { class: "notice" }, words.teachingNow) : null);
  }

  choices(words) {
    const radios = ["travel", "contact"].map((name) => make("label", { class: "choice", for: `approach-${name}` }, this.approach[name], text.setup.approaches[name]));
    const presets = this.told.presets.map((one) => this.preset(words, one));
    return make("div", { class: "choices" },
      make("fieldset", { class: "approach", role: "radiogroup" }, make("legend", {}, words.approach), radios),
      presets.length ? make("fieldset", { class: "presets" }, make("legend", {}, words.presets), presets) : null);
  }

  preset(words, one) {
    const values = { name: one.name, approach: text.setup.approaches[one.approach], mm: shown(one.carina_mm), detail: one.refused };
    if (!one.protocol) return make("p", { class: "soft" }, fill(words.presetRefused, values));
    const label = fill(one.carina === "taught" ? words.presetTaught : words.preset, values);
    return make("button", { type: "button", "data-preset": `${one.name}-${one.approach}-${one.carina}`, onclick: () => this.fillIn(one) }, label);
  }

  group(name, fields) {
    const words = text.setup.protocol;
    const found = fields.map((field) => this.fields.find((one) => one.name === field)).filter(Boolean);
    return make("fieldset", { class: `group group-${name}` }, make("legend", {}, words.groups[name]),
      name === "limits" ? make("p", { class: "field-hint" }, words.limitsHint) : null,
      make("div", { class: "group-fields" }, found.map((one) => one.element)));
  }

  get values() {
    return Object.fromEntries(this.fields.map((one) => [one.name, one.value]));
  }

  get chosen() {
    return this.approach.contact.checked ? "contact" : "travel";
  }

  /** As in force. */
  reset() {
    kept = null;
    this.version = this.told.version;
    this.carina = "known";
    this.put(this.told.approach, this.told.protocol);
    this.reason.value = "";
    this.answer.told("");
    show(this.newer, false);
    this.changed(true);
  }

  /** As it was left. */
  restore() {
    this.version = kept.version;
    this.carina = kept.carina;
    this.put(kept.approach, kept.values);
    this.reason.value = kept.reason;
    if (this.version !== this.told.version) this.showNewer(this.told.version);
    this.changed();
  }

  fillIn(preset) {
    this.carina = preset.carina;
    this.put(preset.approach, preset.protocol);
    this.changed();
  }

  put(approach, values) {
    this.approach[approach].checked = true;
    for (const one of this.fields) one.value = values[one.name];
    this.showApproach();
  }

  approached() {
    this.showApproach();
    this.changed();
  }

  showApproach() {
    for (const one of this.fields) {
      if (BY_CONTACT.has(one.name)) show(one.element, this.chosen === "contact");
    }
  }

  /** Something was typed: keep it, and ask the planner when the typing rests. */
  changed(isFresh = false) {
    if (!isFresh) {
      kept = { version: this.version, approach: this.chosen, carina: this.carina, values: this.values, reason: this.reason.value };
      this.answer.told("");
    }
    for (const one of this.fields) one.compare(this.told.protocol[one.name]);
    say(this.reasonWrong, "");
    this.showWhy();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.ask(), isFresh ? 0 : WAIT_MS);
  }

  async ask() {
    if (!this.context.session.may("see-signals")) {
      this.show({ refused: [], plan: this.told.plan, changes: [], needs: [] });
      return;
    }
    this.asked += 1;
    const mine = this.asked;
    try {
      const found = await this.context.api.query("/protocol/plan", this.draft());
      if (mine === this.asked) this.show(found);
    } catch (error) {
      if (mine === this.asked) say(this.wrong, error.detail || String(error));
    }
  }

  draft() {
    return { approach: this.chosen, carina: this.carina, protocol: this.values };
  }

  show(found) {
    const words = text.setup.protocol;
    this.found = found;
    this.plan.show(found.plan);
    this.refuse(found.refused.map((one) => ({ field: one.field, detail: one.sentence })));
    const list = found.changes.map((one) => this.changeWords(one)).join("; ");
    say(this.changesLine, !found.plan ? "" : list ? fill(words.changes, { list }) : this.told.is_teaching ? "" : words.noChanges);
    const lacking = found.needs.filter((right) => !this.context.session.may(right));
    say(this.needs, lacking.map((right) => words.needs[right] || "").join(" "));
    show(this.reasonPlace, found.needs.includes("change-limits"));
    this.showWhy();
  }

  changeWords(one) {
    const words = text.setup.protocol;
    if (one.field === "approach") return fill(words.change, { field: words.approach, from: text.setup.approaches[one.from], to: text.setup.approaches[one.to] });
    if (one.field === "carina") return fill(words.change, { field: words.carinaField, from: shown(one.from), to: `${shown(one.to)} mm` });
    const field = this.fields.find((each) => each.name === one.field);
    const unit = this.told.fields.find((each) => each.name === one.field)?.unit || "";
    return fill(words.change, { field: field ? field.label : one.field, from: shown(one.from), to: `${shown(one.to)} ${unit}`.trim() });
  }

  /** A sentence of the planner with the names that stand on this page. */
  plainly(field, sentence) {
    const own = sentence.startsWith(`${field} is `) ? sentence.slice(field.length + 4) : sentence;
    const words = own.replace(/\b[a-z]+(?:_[a-z0-9]+)+\b/g, (name) => {
      const found = this.fields.find((one) => one.name === name);
      return found ? `\u201c${found.label}\u201d` : name;
    });
    return words.slice(0, 1).toUpperCase() + words.slice(1);
  }

  /** Say beside each field what is wrong with it, and the rest below. */
  refuse(told) {
    const words = text.setup.protocol;
    const errors = told.map((one) => ({ field: one.field, detail: this.plainly(one.field, one.detail) }));
    for (const one of this.fields) one.refuse(errors.filter((error) => error.field === one.name).map((error) => error.detail).join(" "));
    say(this.reasonWrong, errors.filter((error) => error.field === "reason").map((error) => error.detail).join(" "));
    const names = new Set([...this.fields.filter((one) => !one.element.hidden).map((one) => one.name), "reason"]);
    const others = errors.filter((error) => !names.has(error.field)).map((error) => error.detail);
    const count = errors.length ? fill(words.refused, { count: errors.length }) : "";
    say(this.wrong, [count, ...others].filter(Boolean).join(". "));
  }

  /** Why it cannot be set now; the button stays where it is. */
  showWhy() {
    const { session } = this.context;
    const mine = whyNotMe(session, "choose-protocol", "change-limits");
    const why = mine || whyNotNow(this.context);
    const mayChoose = session.may("choose-protocol");
    for (const one of this.fields) {
      one.lock(GROUPS.limits.includes(one.name) ? !session.may("change-limits") : !mayChoose);
    }
    for (const radio of Object.values(this.approach)) radio.disabled = !mayChoose;
    for (const button of this.form.querySelectorAll("[data-preset]")) show(button, mayChoose);
    say(this.why, why);
    const { found } = this;
    const isNothing = !found || found.refused.length > 0 || !found.plan || (!found.changes.length && !this.told.is_teaching);
    this.set.disabled = Boolean(why) || isNothing || found.needs.some((right) => !session.may(right));
    this.discard.disabled = kept === null;
  }

  async save(event) {
    event.preventDefault();
    if (this.set.disabled) return;
    const body = { ...this.draft(), version: this.version, key: newKey() };
    if (!this.reasonPlace.hidden) body.reason = oneLine(this.reason.value);
    await tried(this.set, this.answer, async () => {
      try {
        this.told = await this.context.api.put("/protocol", body);
      } catch (error) {
        this.refused(error);
        return;
      }
      kept = null;
      this.build();
      this.reset();
      this.answer.told(text.setup.saved, "good");
    });
  }

  refused(error) {
    const version = error.errors?.find((one) => one.field === "version");
    if (version) {
      this.showNewer();
      return;
    }
    if (error.errors?.length) this.refuse(error.errors);
    this.answer.told(`${error.detail}. ${text.setup.kept}`, "bad");
    const first = this.form.querySelector("[aria-invalid]");
    if (first) first.focus();
  }

  /** Somebody else was faster: what was typed stays, and is compared with what is in force now. */
  async showNewer() {
    const words = text.setup.protocol;
    const told = await this.context.api.get("/protocol");
    const take = make("button", { type: "button", onclick: () => this.takeNewer(told, false) }, words.newerTake);
    const keep = make("button", { type: "button", class: "primary", onclick: () => this.takeNewer(told, true) }, words.newerKeep);
    this.newer.replaceChildren(make("p", {}, fill(words.newer, { theirs: told.version, yours: this.version })), make("div", { class: "row" }, keep, take));
    show(this.newer, true);
    keep.focus();
  }

  takeNewer(told, keepMine) {
    const mine = { approach: this.chosen, carina: this.carina, values: this.values, reason: this.reason.value };
    this.told = told;
    kept = keepMine ? { ...mine, version: told.version } : null;
    this.build();
    if (keepMine) this.restore();
    else this.reset();
  }

  openSources() {
    const words = text.setup.protocol;
    const table = (one) => make("section", { class: "sources", "data-own": one.is_patients ? "" : null },
      make("h3", {}, text.setup.patient.ages[one.age] || one.age),
      make("dl", {}, one.limits.map((limit) => {
        const [name, unit] = words.sourceNames[limit.name] || [limit.name, ""];
        return make("div", {}, make("dt", {}, `${name}: ${shown(limit.limit)} ${unit}`.trim()), make("dd", {}, limit.source));
      })));
    const own = [...this.guidelines].sort((a, b) => Number(b.is_patients) - Number(a.is_patients));
    const dialog = openDialog(words.sources, make("div", { class: "all-sources", tabindex: "0" }, own.map(table)));
    mark(dialog.element, "data-wide", "");
  }

  unmount() {
    clearTimeout(this.timer);
    this.asked += 1;
    this.unsubscribe();
    this.unfollow();
  }
}

/** Show the part; gives what takes it away. */
export async function mountProtocol(root, context) {
  const [told, guidelines] = await Promise.all([context.api.get("/protocol"), context.api.get("/guidelines")]);
  const protocol = new Protocol(root, context, told, guidelines);
  return () => protocol.unmount();
}
