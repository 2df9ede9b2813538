// What the state means for a person: a few questions that several parts of the page ask.

import { fill, text } from "./text.js";
import { capital } from "./words.js";
import { GOOD, LOST, CONNECTING } from "./live.js";

const STANDING = new Set(["halted", "out-of-service"]);
const RESTING = new Set(["parked", "halted", "out-of-service"]);

const phases = new Map();

/** Take in what the machine calls its phases (GET /machine). */
export function learnPhases(told) {
  for (const one of told || []) phases.set(one.phase, one);
}

/** Words for a phase: [name, what happens in it]. One that is not known keeps its own name. */
export function phaseWords(phase) {
  const known = phases.get(phase);
  return known ? [known.label, known.meaning] : [phase ? capital(phase.replaceAll("-", " ")) : text.bedside.unknown, ""];
}

/** Whether nothing is under way that a stop would end. */
export function isResting(state) {
  return RESTING.has(state.phase);
}

/** Whether the machine has left the catheter in the patient and does not move it. */
export function isLeftInside(state) {
  return state.is_inside && STANDING.has(state.phase);
}

/** What must be done where the catheter was left inside, in one line. */
export function leftInsideWords(state) {
  const deepest = state.tip_high_mm ?? state.tip_mm;
  if (deepest === null || deepest === undefined) return text.alarm.insideUnknown;
  if (deepest <= 0) return text.alarm.insideShallow;
  return fill(text.alarm.inside, { mm: Math.round(state.tip_mm > 0 ? state.tip_mm : deepest) });
}

/** Why a start would be refused, as far as can be seen; null where nothing speaks against it. */
export function whyNoStart(state, link, session) {
  const why = text.bedside.start.why;
  if (link.kind === LOST || link.kind === CONNECTING) return why.link;
  if (link.kind !== GOOD) return why.silent;
  if (link.hasFailed) return why.failed;
  if (session.name === null) return why.signIn;
  if (session.must_change_password) return why.change;
  if (!session.rights.includes("start")) return why.role;
  return whyMachineNoStart(state, why);
}

function whyMachineNoStart(state, why) {
  if (state.locked_out) return why.lockedOut;
  const phases = {
    halted: why.halted,
    "out-of-service": why.service,
    teaching: why.teaching,
    identifying: why.identifying,
  };
  if (state.phase in phases) return phases[state.phase];
  if (state.phase !== "parked") return why.running;
  if (state.is_inside) return why.inside;
  if (state.catheter_left_s !== null && state.catheter_left_s <= 0) return why.catheter;
  if (state.passes_most && state.passes >= state.passes_most) return why.passes;
  if (state.rest_left_s > 0) return fill(why.rest, { s: Math.ceil(state.rest_left_s) });
  if (state.preoxygenation === "requested") return why.oxygen;
  return null;
}

/** What the machine waits for a person to do, where no alarm says it; null where nothing. */
export function waitsFor(state) {
  const ask = text.alarm.ask;
  if (state.locked_out) return ask.lockedOut;
  if (state.phase === "halted") return ask.halted;
  if (state.phase === "out-of-service") return ask.service;
  if (state.phase !== "parked") return null;
  if (state.preoxygenation === "requested") return ask.oxygen;
  if (state.assessment_due || (state.passes_most && state.passes >= state.passes_most)) {
    return ask.assess;
  }
  return null;
}
