// Buttons of the machine: sent to it, and what it answered.

import { Refused, newKey } from "./api.js";
import { BUTTONS } from "./machine_button.js";
import { fill, text } from "./text.js";

const PRESSED = "pressed";

/** Ask the machine for something; {answer} or {refusal: words}. */
export async function request(api, ask, reason) {
  const body = { ask, key: newKey() };
  if (reason) body.reason = reason;
  try {
    const answer = await api.post("/requests", body);
    const refused = answer.refusal || (answer.verdict === PRESSED ? null : answer.verdict);
    if (refused) return { refusal: fill(text.alarm.action.refused, { detail: words(refused) }) };
    return { answer };
  } catch (error) {
    if (!(error instanceof Refused)) throw error;
    return { refusal: fill(text.alarm.action.failed, { detail: error.detail }) };
  }
}

/** The same of whoever has the button's right; null where it is nobody's who is signed in, who is asked then.
    A page that has just been loaded waits until it knows whose session it is. */
export async function requestAs(context, ask) {
  const { api, session } = context;
  const { right } = BUTTONS[ask];
  try {
    if (!session.may(right)) await api.until(session.firstLook);
  } catch (error) {
    return { refusal: fill(text.alarm.action.failed, { detail: error.detail }) };
  }
  if (session.may(right)) return request(api, ask);
  context.askSignIn();
  return null;
}

function words(refused) {
  if (typeof refused === "string") return refused;
  return [refused.sentence, refused.remedy].filter(Boolean).join(". ");
}
