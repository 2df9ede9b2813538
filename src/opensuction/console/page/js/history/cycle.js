// One cycle: how it ended, its report and recording, a replay, its alarms, what people did in it.

import { make } from "../dom.js";
import { fill, text } from "../text.js";
import { sentence } from "./alarms.js";
import { bytes, cycleAddress, instant, load, outcome, priority, table } from "./parts.js";
import { Replay } from "./replay.js";

function facts(cycle) {
  const words = text.history.cycle;
  const lasted_s = cycle.ended_at ? (Date.parse(cycle.ended_at) - Date.parse(cycle.started_at)) / 1000 : null;
  const listed = [
    [words.started, instant(cycle.started_at)],
    [words.lasted, lasted_s === null ? null : fill(words.seconds, { s: lasted_s.toFixed(1) })],
    [words.why, cycle.why || null],
    [words.patient, cycle.patient ?? text.history.cycles.bench],
    [words.protocol, cycle.protocol],
    [words.approach, words.approaches[cycle.approach] ?? cycle.approach],
    [words.catheter, cycle.catheter],
    [words.machine, cycle.machine],
    [words.asked, cycle.requested_by],
    [words.software, cycle.software],
  ];
  return make("dl", { class: "facts" }, listed.filter(([, value]) => value !== null).map(([name, value]) => make("div", {}, make("dt", {}, name), make("dd", {}, value))));
}

function files(cycle) {
  const words = text.history.cycle;
  if (cycle.outcome === null) return make("p", { class: "history-note" }, words.notEnded);
  if (cycle.recording_fault) return make("p", { class: "verdict bad" }, `\u2715 ${fill(words.fault, { fault: cycle.recording_fault })}`);
  if (!cycle.has_recording) return make("p", { class: "history-note" }, words.noRecording);
  const address = `api/v1/cycles/${encodeURIComponent(cycle.id)}/recording`;
  const links = [make("a", { class: "button primary", href: `${cycleAddress(cycle.id)}/report` }, words.report)];
  links.push(make("a", { class: "button", href: address, download: "" }, fill(words.recording, { size: bytes(cycle.recording_bytes) })));
  for (let n = 2; n <= cycle.recording_parts; n += 1) links.push(make("a", { class: "button", href: `${address}?part=${n}`, download: "" }, fill(words.part, { n })));
  const row = make("div", { class: "row" }, links);
  return cycle.recording_bound ? row : make("div", {}, row, make("p", { class: "history-note" }, words.unbound));
}

/** A section that asks for its own rows. */
function listed(title, none, ask, heads, cells) {
  const body = make("div", {});
  const end = load(body, ask, (found) => {
    body.replaceChildren(found.length ? table(title, heads, found.map(cells)).element : make("p", { class: "history-note" }, none));
  });
  return { element: make("section", {}, make("h2", {}, title), body), end };
}

function alarmsOf(api, id) {
  const words = text.history.alarms;
  return listed(text.history.cycle.alarms, text.history.cycle.noAlarms,
    async () => (await api.get(`/alarms?limit=200&cycle=${encodeURIComponent(id)}`)).alarms.reverse(),
    [words.raised, words.priority, words.what], (alarm) => [instant(alarm.raised_at), priority(alarm), sentence(alarm)]);
}

function actionsOf(api, id) {
  const words = text.history.audit;
  return listed(text.history.cycle.actions, text.history.cycle.noActions,
    async () => (await api.get(`/actions?limit=200&cycle=${encodeURIComponent(id)}`)).actions.reverse(),
    [words.at, words.who, words.what, words.detail], (action) => [instant(action.done_at), action.done_by, action.what, action.detail]);
}

export function mountCycle(root, context, id) {
  const words = text.history.cycle;
  const ends = [];
  ends.push(load(root, () => context.api.get(`/cycles/${encodeURIComponent(id)}`), (cycle) => {
    const parts = [alarmsOf(context.api, id)];
    if (context.session.may("see-audit")) parts.push(actionsOf(context.api, id));
    ends.push(...parts.map((part) => part.end));
    const replay = cycle.has_recording && !cycle.recording_fault ? new Replay(context.api, id) : null;
    if (replay) ends.push(() => replay.close());
    const inside = cycle.inside_at_end ? make("p", { class: "verdict bad" }, `\u2715 ${words.inside}`) : null;
    const title = make("h2", { class: "cycle-title", tabindex: "-1" }, fill(words.title, cycle));
    root.replaceChildren(make("article", { class: "cycle" },
      make("p", {}, make("a", { class: "history-open", href: "#/history/cycles" }, `\u2190 ${words.back}`)),
      make("div", { class: "cycle-head" }, title, outcome(cycle)),
      ...(inside ? [inside] : []), files(cycle), facts(cycle), ...parts.map((part) => part.element), ...(replay ? [replay.element] : [])));
    // Whoever came by keyboard goes on here: the link that was pressed is gone.
    if (document.activeElement === document.body) title.focus({ preventScroll: true });
  }));
  return () => ends.forEach((end) => end());
}
