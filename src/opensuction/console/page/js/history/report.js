// A cycle's report within the page, so that STOP and the alarms stay in reach. It is sandboxed.

import { make } from "../dom.js";
import { fill, text } from "../text.js";
import { cycleAddress, load } from "./parts.js";

const PATIENCE_MS = 120000;

export function mountReport(root, context, id) {
  const words = text.history.cycle;
  const path = `/cycles/${encodeURIComponent(id)}`;
  const bar = make("p", { class: "report-bar" }, make("a", { class: "history-open", href: cycleAddress(id) }, `\u2190 ${text.history.cycle.back}`));
  const place = make("div", { class: "report-place" });
  root.replaceChildren(bar, place);
  return load(place, async () => {
    const cycle = await context.api.get(path);
    bar.replaceChildren(
      make("a", { class: "history-open", href: cycleAddress(id) }, `\u2190 ${fill(words.backToCycle, cycle)}`),
      make("a", { class: "history-open", href: `api/v1${path}/report`, target: "_blank", rel: "noopener" }, words.ownWindow));
    place.replaceChildren(make("p", { class: "history-note", role: "status" }, words.making));
    await context.api.fetch("GET", `${path}/report`, undefined, PATIENCE_MS); // made now, or refused with a reason
    return cycle;
  }, (cycle) => {
    place.replaceChildren(make("iframe", { class: "report-frame", title: fill(words.frame, cycle), sandbox: "allow-scripts allow-modals", src: `api/v1${path}/report` }));
  });
}
