// Tokens of other programs, which only read.

import { make } from "../dom.js";
import { field, form, openDialog } from "../dialog.js";
import { fill, text } from "../text.js";
import { day } from "../words.js";
import { showSecret } from "./secret.js";

export class Tokens {
  constructor(context) {
    this.api = context.api;
    const words = text.account.tokens;
    this.rows = make("tbody");
    this.wrong = make("p", { class: "form-refused", role: "alert" });
    this.element = make("section", { class: "people-tokens" },
      make("h2", {}, words.title), make("p", {}, words.say),
      make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": words.title },
        make("table", {}, make("thead", {}, make("tr", {}, [words.label, words.scope, words.expires].map((head) => make("th", { scope: "col" }, head)), make("td", {}))), this.rows)),
      this.wrong,
      make("button", { type: "button", class: "primary", onclick: () => this.add() }, words.add));
    this.load();
  }

  async load() {
    const words = text.account.tokens;
    try {
      const tokens = await this.api.get("/tokens");
      const none = make("tr", {}, make("td", { colspan: 4 }, words.none));
      this.rows.replaceChildren(...(tokens.length ? tokens.map((token) => this.row(token)) : [none]));
      this.wrong.textContent = "";
    } catch (error) {
      this.wrong.textContent = error.detail || String(error);
    }
  }

  row(token) {
    const words = text.account.tokens;
    return make("tr", {},
      make("th", { scope: "row" }, token.label),
      make("td", {}, [...token.scope].join(", ")),
      make("td", {}, day(token.expires_at)),
      make("td", { class: "row" }, make("button", { type: "button", "aria-label": `${words.revoke}: ${token.label}`, onclick: () => this.revoke(token) }, words.revoke)));
  }

  revoke(token) {
    const words = text.account.tokens;
    const { element } = form({}, words.revoke, async () => {
      await this.api.remove(`/tokens/${encodeURIComponent(token.id)}`);
      dialog.close();
      this.load();
    });
    const dialog = openDialog(fill(words.revokeTitle, token), make("div", {}, make("p", {}, words.revokeSay), element));
  }

  async add() {
    const words = text.account.tokens;
    const rights = (await this.api.get("/rights")).filter((one) => one.is_read_only);
    const boxes = rights.map((one) => make("label", { class: "check" }, make("input", { type: "checkbox", value: one.right, checked: one.right === "see-history" }), one.sentence));
    const fields = {
      label: field("label", words.label, { maxlength: 64, required: true }),
      days: field("days", words.days, { type: "number", min: 1, max: 366, value: 90, required: true }),
    };
    const scopes = make("fieldset", {}, make("legend", {}, words.scope), boxes);
    const { element } = form(fields, words.addSubmit, async ({ label, days }) => {
      const scope = [...scopes.querySelectorAll("input:checked")].map((box) => box.value);
      const made = await this.api.post("/tokens", { label, scope, lasts_s: 86400 * Math.round(Number(days)) });
      dialog.close();
      this.load();
      showSecret(fill(words.made, { label }), made.token, fill(words.madeSay, { until: day(made.expires_at) }));
    }, [scopes]);
    const dialog = openDialog(words.add, element);
  }
}
