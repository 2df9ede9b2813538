// Setup: one part at a time. What somebody typed stays, whichever part is shown.

import { make, mark } from "../dom.js";
import { fill, text } from "../text.js";
import { mountCatheter } from "./catheter.js";
import { mountIdentification } from "./identification.js";
import { mountPatient } from "./patient.js";
import { mountProtocol } from "./protocol.js";
import { mountTeaching } from "./teaching.js";

const PARTS = {
  protocol: mountProtocol,
  patient: mountPatient,
  teaching: mountTeaching,
  catheter: mountCatheter,
  identification: mountIdentification,
};
const SEEN = { identification: "see-signals" };

let chosen = "protocol";

class Setup {
  constructor(root, context) {
    this.context = context;
    this.unmount = () => {};
    const names = Object.keys(PARTS).filter((name) => context.session.may(SEEN[name] || "see-bedside"));
    if (!names.includes(chosen)) chosen = "protocol";
    this.tabs = names.map((name) => make("button", {
      type: "button", role: "tab", id: `part-${name}`, "aria-controls": "setup-part", "data-part": name,
      onclick: () => this.open(name), onkeydown: (event) => this.walk(event, names),
    }, text.setup.parts[name]));
    this.part = make("div", { class: "setup-part", id: "setup-part", role: "tabpanel" });
    root.replaceChildren(make("div", { class: "setup" },
      make("h1", { class: "hidden-title" }, text.setup.title),
      make("div", { class: "setup-tabs", role: "tablist", "aria-label": text.setup.partsLabel }, this.tabs),
      this.part));
    this.open(chosen);
  }

  walk(event, names) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const next = names[(names.indexOf(chosen) + step + names.length) % names.length];
    this.open(next);
    this.tabs.find((tab) => tab.dataset.part === next).focus();
  }

  open(name) {
    chosen = name;
    this.unmount();
    this.unmount = () => {};
    for (const tab of this.tabs) {
      const isChosen = tab.dataset.part === name;
      mark(tab, "aria-selected", isChosen ? "true" : "false");
      mark(tab, "tabindex", isChosen ? "0" : "-1");
    }
    mark(this.part, "aria-labelledby", `part-${name}`);
    const place = make("div", {}, make("p", { class: "view-note" }, text.setup.loading));
    this.part.replaceChildren(place);
    let isGone = false;
    let unmount = () => {};
    this.unmount = () => {
      isGone = true;
      unmount();
    };
    PARTS[name](place, this.context).then((found) => {
      if (isGone) found();
      else unmount = found;
    }).catch((error) => {
      place.replaceChildren(
        make("p", { class: "view-note" }, fill(text.setup.failed, { detail: error.detail || String(error) })),
        make("button", { type: "button", onclick: () => this.open(name) }, text.setup.again),
      );
    });
  }
}

/** Show the view; gives what takes it away. */
export function mount(root, context) {
  const setup = new Setup(root, context);
  return () => setup.unmount();
}
