// The table of rights, as the machine has it (GET /rights).

import { make } from "../dom.js";
import { text } from "../text.js";

/** The table; raises Refused. */
export async function rightsTable(api) {
  const words = text.account.rights;
  const rights = await api.get("/rights");
  const roles = Object.entries(text.shell.roles);
  const heads = [words.right, words.anybody, ...roles.map(([, name]) => name), words.administrator];
  const cell = (has) => make("td", { class: has ? "has" : "has-not" }, make("span", { "aria-hidden": "true" }, has ? "\u2713" : "\u2013"), make("span", { class: "hidden-title" }, has ? words.yes : words.no));
  const row = (one) => make("tr", {},
    make("th", { scope: "row" }, one.sentence + (one.needs_reason ? `, ${words.reason}` : "")),
    cell(one.by_anybody),
    roles.map(([role]) => cell(one.by_anybody || one.roles.includes(role))),
    cell(one.by_anybody || one.by_administrator));
  return make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": words.title },
    make("table", { class: "rights" }, make("thead", {}, make("tr", {}, heads.map((head) => make("th", { scope: "col" }, head)))), make("tbody", {}, rights.map(row))));
}
