// What has been: cycles, alarms, trends, and who did what. The address says which part is shown.

import { make } from "../dom.js";
import { text } from "../text.js";
import { mountAlarms } from "./alarms.js";
import { mountAudit } from "./audit.js";
import { mountCycle } from "./cycle.js";
import { mountCycles } from "./cycles.js";
import { mountReport } from "./report.js";
import { mountTrends } from "./trends.js";

const TABS = {
  cycles: { mount: mountCycles, right: "see-history" },
  alarms: { mount: mountAlarms, right: "see-history" },
  trends: { mount: mountTrends, right: "see-history" },
  audit: { mount: mountAudit, right: "see-audit" },
};

/** The parts of the address behind ``#/history/``. */
function place() {
  return location.hash.replace(/^#\/?/, "").split("?")[0].split("/").slice(1).filter(Boolean).map(decoded);
}

function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return "";
  }
}

function navigation(context, now) {
  const links = Object.keys(TABS)
    .filter((name) => context.session.may(TABS[name].right))
    .map((name) => make("a", { href: `#/history/${name}`, "aria-current": name === now ? "page" : null }, text.history.tab[name]));
  return make("nav", { class: "history-tabs", "aria-label": text.history.tabs }, links);
}

/** Show the view; gives what takes it away. */
export function mount(root, context) {
  const [first = "cycles", id, more] = place();
  const isCycle = first === "cycle" && id;
  const name = isCycle ? "cycles" : first in TABS && context.session.may(TABS[first].right) ? first : "cycles";
  const body = make("div", { class: "history-body" });
  if (isCycle && more === "report") {
    root.replaceChildren(make("div", { class: "history wide" }, body));
    return mountReport(body, context, id);
  }
  root.replaceChildren(make("div", { class: "history" }, make("h1", { class: "hidden-title" }, text.history.title), navigation(context, name), body));
  return isCycle ? mountCycle(body, context, id) : TABS[name].mount(body, context);
}
