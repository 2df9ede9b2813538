// People: one's own account, and for administrators accounts, tokens and who may do what.

import { make } from "../dom.js";
import { fill, text } from "../text.js";
import { Accounts } from "./accounts.js";
import { rightsTable } from "./rights.js";
import { openPassword, openSignIn } from "./sign_in.js";
import { Tokens } from "./tokens.js";

function own(session) {
  const words = text.account;
  if (session.name === null) {
    return make("section", { class: "people-own" }, make("p", {}, words.nobody),
      make("button", { type: "button", class: "primary", onclick: () => openSignIn(session) }, text.shell.signIn));
  }
  const role = text.shell.roles[session.role] || session.role;
  return make("section", { class: "people-own" }, make("p", {}, fill(words.yours, { name: session.name, role })),
    make("div", { class: "row" },
      make("button", { type: "button", onclick: () => openPassword(session) }, words.password.open),
      make("button", { type: "button", onclick: () => session.signOut().catch(() => {}) }, text.shell.signOut)));
}

/** Show the view; gives what takes it away. */
export function mount(root, context) {
  const { session } = context;
  const parts = [make("h1", {}, text.account.title), own(session)];
  if (session.may("manage-accounts")) parts.push(new Accounts(context).element);
  if (session.may("manage-tokens")) parts.push(new Tokens(context).element);
  const rights = make("section", { class: "people-rights" });
  if (session.name !== null) {
    rightsTable(context.api).then((table) => rights.replaceChildren(make("h2", {}, text.account.rights.title), table)).catch((error) => rights.replaceChildren(make("p", { class: "form-refused" }, error.detail || String(error))));
  }
  parts.push(rights);
  root.replaceChildren(make("div", { class: "people" }, parts));
  return () => {};
}
