// One number of a protocol: its unit, its range, what is in force, why it cannot be, where it is from.

import { make, mark, say, show } from "../dom.js";
import { fill, text } from "../text.js";
import { capital } from "../words.js";
import { shown } from "./part.js";

/** A field. told: its row of GET /protocol; limit: {limit, unit, source} or null. */
export function numberField(told, limit, onchange) {
  const words = text.setup.protocol;
  const label = words.fields[told.name] || told.name;
  const id = `draft-${told.name}`;
  const range = fill(told.is_above ? words.rangeAbove : words.range, { least: told.least, most: told.most, unit: told.unit });
  const wrong = make("span", { class: "field-wrong", id: `${id}-wrong` });
  const before = make("span", { class: "in-force" });
  const hint = make("span", { class: "field-hint", id: `${id}-hint` }, range, before);
  const input = make("input", {
    id, name: told.name, inputmode: "decimal", autocomplete: "off", spellcheck: "false",
    "aria-describedby": `${id}-wrong ${id}-hint`,
  });
  const about = make("div", { class: "field-about", id: `${id}-about`, hidden: true },
    make("p", {}, `${capital(told.meaning)}.`),
    make("p", {}, fill(words.source, { source: told.default_source })),
    limit ? make("p", {}, fill(words.guideline, limit)) : null);
  const ask = make("button", {
    type: "button", class: "ask", "aria-expanded": "false", "aria-controls": about.id,
    "aria-label": fill(words.explain, { field: label }),
  }, "?");
  ask.addEventListener("click", () => {
    show(about, about.hidden);
    mark(ask, "aria-expanded", about.hidden ? "false" : "true");
  });
  about.addEventListener("keydown", (event) => event.key === "Escape" && ask.click());
  let raw = null; // the whole number, where nobody has typed another one
  input.addEventListener("input", () => {
    raw = null;
    onchange();
  });
  const element = make("div", { class: "number-field" },
    make("label", { class: "field-label", for: id }, label),
    make("div", { class: "number-row" }, input, make("span", { class: "number-unit" }, told.unit), ask),
    wrong, hint, about);
  return {
    element,
    input,
    name: told.name,
    label,
    /** What is meant; null where nothing is there, the words where they are no number. */
    get value() {
      if (raw !== null) return raw;
      const typed = input.value.trim().replace(",", ".");
      if (typed === "") return null;
      const number = Number(typed);
      return Number.isFinite(number) ? number : typed.slice(0, 60);
    },
    set value(value) {
      raw = typeof value === "number" ? value : null;
      input.value = typeof value === "number" ? shown(value) : value ?? "";
    },
    refuse(sentence) {
      say(wrong, sentence);
      mark(input, "aria-invalid", sentence ? "true" : null);
    },
    compare(value) {
      say(before, this.value === value ? "" : ` · ${fill(words.inForceIs, { value: shown(value) })}`);
      mark(element, "data-changed", this.value !== value);
    },
    lock(isLocked) {
      mark(input, "readonly", isLocked);
      mark(element, "data-locked", isLocked);
    },
  };
}
