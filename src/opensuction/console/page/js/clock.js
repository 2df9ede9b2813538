// The machine's clock, the only one that the page shows: events, reports and records go by it, and the
// one of the device in front of a person may be any.

const SPAN_MS = 10000;

let latest_ms = -Infinity; // how far the machine's clock is ahead of the page's own, in this span
let before_ms = -Infinity; // and in the one before
let span_ms = -Infinity; // when this span began
let tick = 0;

/** Take in what a state tells. A message comes late or in time, never early: of those of the last 10
    to 20 s the one that shows the latest time is right. */
export function hearTime(state, now_ms = performance.now()) {
  const told_ms = Date.parse(state.utc) + (state.connected ? 1000 * state.age_s : 0);
  if (!Number.isFinite(told_ms)) return;
  if (state.tick < tick) latest_ms = before_ms = -Infinity; // another controller: its clock may be another
  tick = state.tick;
  if (now_ms - span_ms > SPAN_MS) {
    before_ms = latest_ms;
    latest_ms = -Infinity;
    span_ms = now_ms;
  }
  latest_ms = Math.max(latest_ms, told_ms - now_ms);
}

/** What the machine's clock shows now, in ms since 1970; null before it has told. */
export function machineNow(now_ms = performance.now()) {
  const ahead_ms = Math.max(latest_ms, before_ms);
  return Number.isFinite(ahead_ms) ? now_ms + ahead_ms : null;
}

/** How far this device's clock is ahead of the machine's, in s; 0 where nobody knows. */
export function deviceAhead() {
  const machine_ms = machineNow();
  return machine_ms === null ? 0 : (Date.now() - machine_ms) / 1000;
}
