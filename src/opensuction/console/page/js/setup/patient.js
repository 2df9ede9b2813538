// Who lies there, as far as the machine's settings depend on it.

import { newKey } from "../api.js";
import { make, say, show } from "../dom.js";
import { field, form } from "../dialog.js";
import { fill, text } from "../text.js";
import { answerLine, fact, shown, whyNotMe, whyNotNow } from "./part.js";

/** Show the part; gives what takes it away. */
export async function mountPatient(root, context) {
  let told = await context.api.get("/patient");
  const words = text.setup.patient;
  if (told.is_bench) {
    root.replaceChildren(make("p", { class: "view-note" }, words.none));
    return () => {};
  }
  const answer = answerLine();
  const why = make("p", { class: "setup-why", role: "status" });
  const pseudonym = field("pseudonym", words.pseudonym, { value: told.pseudonym ?? "", maxlength: 64, autocomplete: "off", autocapitalize: "none", spellcheck: "false" }, words.pseudonymHint);
  const made = form({ pseudonym }, words.set, async (values) => {
    told = await context.api.put("/patient", { pseudonym: values.pseudonym.trim(), version: told.version, key: newKey() });
    answer.told(text.setup.saved, "good");
  });
  const facts = make("dl", { class: "facts" },
    fact(words.age, words.ages[told.age] || told.age),
    fact(words.tube, `${shown(told.tube_mm)} mm`),
    fact(words.length, `${shown(told.tube_length_mm)} mm`),
    fact(words.weight, `${shown(told.weight_kg)} kg`),
    fact(words.catheter, `${shown(told.catheter_mm)} mm`),
    fact(words.carina, `${shown(told.carina_mm)} mm`),
    fact(words.peep, `${shown(told.peep_cmh2o)} cmH\u2082O`));
  root.replaceChildren(make("div", { class: "setup-columns" },
    make("section", {}, made.element, why, answer.element),
    make("section", {}, facts, make("p", { class: "notice" }, fill(words.fixed, { why: told.fixed })))));
  const look = () => {
    const reason = whyNotMe(context.session, "choose-protocol") || whyNotNow(context);
    say(why, reason);
    show(why, reason !== "");
    made.submit.disabled = reason !== "";
    pseudonym.input.readOnly = !context.session.may("choose-protocol");
  };
  const ends = [context.live.subscribe(look), context.live.follow(look)];
  return () => ends.forEach((end) => end());
}
