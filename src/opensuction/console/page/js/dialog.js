// Dialogs. They lie over the view and the navigation only: the alarm bar and STOP stay in reach, so
// none of them is modal to the whole page.

import { make, mark, say } from "./dom.js";
import { Refused } from "./api.js";
import { text } from "./text.js";

let open = null;

/** Whether a dialog is open. */
export const isOpen = () => open !== null;

/** Close what is open. */
export const closeDialog = () => open?.close();

/** Open a dialog with a title and content; gives {element, close}. Another that is open is closed.

    onclose: called once it is gone, whoever closed it. isFirm: Esc does not close it. */
export function openDialog(title, content, { onclose = () => {}, isFirm = false } = {}) {
  if (open) open.close();
  const before = document.activeElement;
  const heading = make("h2", { id: "dialog-title" }, title);
  const cross = make("button", { type: "button", class: "dialog-close", "aria-label": text.shell.close }, "\u00d7");
  const element = make(
    "section",
    { class: "dialog", role: "dialog", "aria-labelledby": "dialog-title" },
    make("div", { class: "dialog-head" }, heading, isFirm ? null : cross),
    content,
  );
  const place = make("div", { class: "dialog-place" }, element);
  const covered = document.querySelectorAll("[data-covered]");
  const dialog = {
    element,
    close() {
      if (open !== dialog) return;
      open = null;
      place.remove();
      for (const part of covered) part.inert = false;
      if (before instanceof HTMLElement && before.isConnected) before.focus();
      onclose();
    },
  };
  cross.addEventListener("click", () => dialog.close());
  place.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !isFirm) dialog.close();
  });
  open = dialog;
  for (const part of covered) part.inert = true;
  document.querySelector(".stage").append(place);
  const first = element.querySelector("input, select, textarea") || element.querySelector("button:not(.dialog-close)");
  (first || cross).focus();
  return dialog;
}

/** A labelled input with a hint and room for what is wrong with it. */
export function field(name, label, attributes = {}, hint = "") {
  const id = `field-${name}`;
  const wrong = make("span", { class: "field-wrong", id: `${id}-wrong` });
  const about = hint ? make("span", { class: "field-hint", id: `${id}-hint` }, hint) : null;
  const kind = attributes.options ? "select" : "input";
  const { options, ...others } = attributes;
  const input = make(kind, { id, name, "aria-describedby": `${hint ? `${id}-hint ` : ""}${id}-wrong`, ...others });
  if (options) input.append(...options.map(([value, words]) => make("option", { value }, words)));
  const element = make("div", { class: "field" }, make("label", { class: "field-label", for: id }, label), input, about, wrong);
  return {
    element,
    input,
    refuse(words) {
      say(wrong, words);
      mark(input, "aria-invalid", words ? "true" : null);
    },
  };
}

/** What a person typed as a reason, as it goes on record: one line, without spaces around it. */
export function oneLine(typed) {
  return typed.replace(/\s+/g, " ").trim();
}

/** A form that sends once, says what is refused, beside the field where it belongs to one.

    fields: {name: field}. send(values) may raise Refused. */
export function form(fields, label, send, extra = []) {
  const refused = make("p", { class: "form-refused", role: "alert" });
  const submit = make("button", { type: "submit", class: "primary" }, label);
  const element = make("form", { class: "form", novalidate: true }, Object.values(fields).map((one) => one.element), extra, refused, submit);
  const refuse = (error) => {
    let told = false;
    for (const [name, one] of Object.entries(fields)) {
      const words = error.of(name);
      one.refuse(words);
      told = told || words !== "";
    }
    say(refused, told ? "" : error.detail);
    const wrong = element.querySelector("[aria-invalid]");
    if (wrong) wrong.focus();
  };
  element.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (submit.disabled) return;
    submit.disabled = true;
    say(refused, "");
    for (const one of Object.values(fields)) one.refuse("");
    const values = Object.fromEntries(Object.entries(fields).map(([name, { input }]) => [name, input.type === "checkbox" ? input.checked : name === "reason" ? oneLine(input.value) : input.value]));
    try {
      await send(values);
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      refuse(error);
      if (error.wait_s) await countWait(submit, refused, error);
    } finally {
      submit.disabled = false;
      say(submit, label);
    }
  });
  return { element, refuse, submit };
}

/** Hold a button back until a wait is over, and show how long. */
async function countWait(button, refused, error) {
  const until_ms = performance.now() + 1000 * error.wait_s;
  for (;;) {
    const left_s = Math.ceil((until_ms - performance.now()) / 1000);
    if (left_s <= 0 || !button.isConnected) break;
    say(button, text.account.signIn.wait.replace("{left}", `${left_s} s`));
    await new Promise((done) => { setTimeout(done, 250); });
  }
  say(refused, "");
}

/** Ask before something is done: title, sentence, button. The promise tells whether to. */
export function confirm(title, sentence, label) {
  return new Promise((done) => {
    let answer = false;
    const yes = make("button", { type: "button", class: "primary" }, label);
    const no = make("button", { type: "button" }, text.shell.cancel);
    const dialog = openDialog(title, make("div", {}, make("p", {}, sentence), make("div", { class: "row" }, yes, no)), {
      onclose: () => done(answer),
    });
    yes.addEventListener("click", () => {
      answer = true;
      dialog.close();
    });
    no.addEventListener("click", () => dialog.close());
  });
}

