// Accounts: who may sign in, as what.

import { make } from "../dom.js";
import { field, form, openDialog } from "../dialog.js";
import { fill, text } from "../text.js";
import { day } from "../words.js";
import { showSecret } from "./secret.js";

const path = (name) => `/accounts/${encodeURIComponent(name)}`;

export class Accounts {
  constructor(context) {
    this.api = context.api;
    this.rows = make("tbody");
    this.wrong = make("p", { class: "form-refused", role: "alert" });
    const words = text.account.accounts;
    const heads = [words.name, words.role, words.administrator, words.state];
    this.element = make("section", { class: "people-accounts" },
      make("h2", {}, words.title),
      make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": words.title },
        make("table", {}, make("thead", {}, make("tr", {}, heads.map((head) => make("th", { scope: "col" }, head)), make("td", {}))), this.rows)),
      this.wrong,
      make("button", { type: "button", class: "primary", onclick: () => this.add() }, words.add));
    this.load();
  }

  async load() {
    try {
      const accounts = await this.api.get("/accounts");
      this.rows.replaceChildren(...accounts.map((account) => this.row(account)));
      this.wrong.textContent = "";
    } catch (error) {
      this.wrong.textContent = error.detail || String(error);
    }
  }

  row(account) {
    const words = text.account.accounts;
    const state = !account.is_active ? words.inactive : account.has_one_time_password ? words.oneTime : words.active;
    const action = (label, act) => make("button", { type: "button", "aria-label": `${label}: ${account.name}`, onclick: act }, label);
    return make("tr", {},
      make("th", { scope: "row" }, account.name),
      make("td", {}, text.shell.roles[account.role] || account.role),
      make("td", {}, account.is_administrator ? words.yes : words.no),
      make("td", {}, state),
      make("td", { class: "row" },
        account.is_active ? action(words.change, () => this.change(account)) : null,
        action(words.reset, () => this.reset(account)),
        account.is_active ? action(words.deactivate, () => this.deactivate(account)) : null));
  }

  roleFields(account = null) {
    const words = text.account.accounts;
    const roles = Object.entries(text.shell.roles);
    const fields = {
      role: field("role", words.role, { options: roles }),
      is_administrator: field("is_administrator", `${words.administrator}: ${words.isAdministrator}`, { type: "checkbox" }),
    };
    fields.role.input.value = account?.role ?? "clinician";
    fields.is_administrator.input.checked = account?.is_administrator ?? false;
    return fields;
  }

  reasonField() {
    return field("reason", text.account.accounts.reason, { maxlength: 500, required: true });
  }

  /** A dialog with a form that changes something, and the list anew. */
  ask(title, sentence, fields, label, send) {
    const { element } = form(fields, label, async (values) => {
      const made = await send(values);
      dialog.close();
      this.load();
      if (made?.one_time_password) this.showPassword(made);
    });
    const dialog = openDialog(title, make("div", {}, sentence ? make("p", {}, sentence) : null, element));
  }

  showPassword(made) {
    const words = text.account.accounts;
    showSecret(fill(words.made, { name: made.account }), made.one_time_password, fill(words.madeSay, { until: day(made.expires_at) }));
  }

  add() {
    const words = text.account.accounts;
    const name = field("name", words.name, { autocomplete: "off", autocapitalize: "none", spellcheck: "false", maxlength: 32, required: true }, words.nameRule);
    this.ask(words.add, "", { name, ...this.roleFields() }, words.addSubmit, (values) => this.api.post("/accounts", values));
  }

  change(account) {
    const words = text.account.accounts;
    const fields = { ...this.roleFields(account), reason: this.reasonField() };
    this.ask(fill(words.changeTitle, account), "", fields, words.save, (values) => this.api.put(path(account.name), values));
  }

  deactivate(account) {
    const words = text.account.accounts;
    this.ask(fill(words.deactivateTitle, account), fill(words.deactivateSay, account), { reason: this.reasonField() }, words.deactivate,
      (values) => this.api.remove(path(account.name), values));
  }

  reset(account) {
    const words = text.account.accounts;
    this.ask(fill(words.resetTitle, account), fill(words.resetSay, account), {}, words.reset, () => this.api.post(`${path(account.name)}/password`));
  }
}
