// What is shown only once: a one-time password, a token.

import { make, say } from "../dom.js";
import { openDialog } from "../dialog.js";
import { text } from "../text.js";

/** Show a secret until it is closed. */
export function showSecret(title, secret, sentence, onclose = () => {}) {
  const words = text.account.accounts;
  const shown = make("output", { class: "secret", tabindex: "0" }, secret);
  const copy = make("button", { type: "button", class: "primary" }, words.copy);
  copy.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(secret);
      say(copy, words.copied);
    } catch {
      getSelection().selectAllChildren(shown); // no clipboard here: it can be copied by hand
    }
  });
  const close = make("button", { type: "button" }, text.shell.close);
  const dialog = openDialog(title, make("div", {}, make("p", {}, sentence), shown, make("div", { class: "row" }, copy, close)), { onclose, isFirm: true });
  close.addEventListener("click", () => dialog.close());
}
