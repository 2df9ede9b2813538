// The dialogs of one's own account: sign in, and choose a password.

import { Refused } from "../api.js";
import { make } from "../dom.js";
import { field, form, openDialog } from "../dialog.js";
import { text } from "../text.js";

/** Ask for name and password. */
export function openSignIn(session) {
  const words = text.account.signIn;
  const fields = {
    name: field("name", words.name, { autocomplete: "username", autocapitalize: "none", spellcheck: "false", maxlength: 64, required: true }),
    password: field("password", words.password, { type: "password", autocomplete: "current-password", maxlength: 1024, required: true }),
  };
  const { element } = form(fields, words.submit, async ({ name, password }) => {
    try {
      await session.signIn(name, password);
    } catch (error) {
      fields.password.input.value = "";
      throw error;
    }
    if (session.must_change_password) openPassword(session, password);
    else dialog.close();
  });
  const said = make("p", { class: "dialog-note" }, words.stop);
  const ended = session.hasEnded ? make("p", { class: "form-refused" }, words.ended) : null;
  const dialog = openDialog(words.title, make("div", {}, ended, element, said));
}

/** Choose a password of one's own. known: the present one, where it has just been typed. */
export function openPassword(session, known = null) {
  const words = text.account.password;
  const kind = { type: "password", maxlength: 1024, required: true };
  const fields = {
    ...(known === null ? { present: field("present", words.present, { ...kind, autocomplete: "current-password" }) } : {}),
    wanted: field("wanted", words.wanted, { ...kind, autocomplete: "new-password" }, words.rule),
    repeat: field("repeat", words.repeat, { ...kind, autocomplete: "new-password" }),
  };
  const { element } = form(fields, words.submit, async ({ present, wanted, repeat }) => {
    if (wanted !== repeat) throw new Refused(422, words.differ, [{ field: "repeat", detail: words.differ }]);
    await session.changePassword(known ?? present, wanted);
    dialog.close();
  });
  // So that a browser that keeps passwords knows whose this is.
  element.prepend(make("input", { hidden: true, autocomplete: "username", value: session.name ?? "", "aria-hidden": "true" }));
  const must = session.must_change_password ? make("p", {}, words.must) : null;
  const dialog = openDialog(words.title, make("div", {}, must, element));
}
