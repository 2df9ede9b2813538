// The airway's drawing: its still part is the machine's (GET /anatomy.svg), this moves the catheter.

import { make, mark } from "../dom.js";
import { text } from "../text.js";

const DRAWN = ["target_mm", "cap_mm", "carina_mm", "boundary_mm"];
const TIP_PX = 5; // the tip's circle ends where the catheter ends
const LABEL_PX = 46;
const COMING = "coming";
const OUT_SHARE = 0.86; // of the conduit that the catheter fills while it is out

export class Drawing {
  constructor(context) {
    this.context = context;
    this.element = make("figure", { class: "anatomy-figure", "aria-label": text.bedside.anatomy });
    this.svg = null;
    this.depths = null;
  }

  /** Load the drawing of a machine; again only where its depths are others. */
  async load(machine) {
    const told = machine.anatomy || {};
    const known = DRAWN.filter((name) => typeof told[name] === "number");
    const query = new URLSearchParams([...known.map((name) => [name, told[name]]), ["by_contact", machine.approach === "contact"]]).toString();
    if (query === this.depths) return;
    try {
      const answer = await this.context.api.fetch("GET", `/anatomy.svg?${query}`);
      const parsed = new DOMParser().parseFromString(await answer.text(), "image/svg+xml");
      this.take(document.importNode(parsed.documentElement, true));
      this.depths = query;
    } catch {
      if (!this.svg) this.element.replaceChildren(make("p", { class: "view-note" }, text.bedside.noAnatomy));
    }
  }

  take(svg) {
    const figures = svg.dataset;
    this.centre_px = Number(figures.centrePx);
    this.px_per_mm = Number(figures.pxPerMm);
    this.above_mm = Number(figures.aboveMm);
    this.straight_mm = Number(figures.straightMm);
    this.boundary_mm = figures.boundaryMm === "" ? null : Number(figures.boundaryMm);
    this.parts = {};
    for (const part of svg.querySelectorAll("[data-part]")) this.parts[part.dataset.part] = part;
    this.from_px = Number(this.parts.straight.dataset.fromPx);
    this.svg = svg;
    this.element.replaceChildren(svg);
    if (this.last) this.update(this.last);
  }

  y_px(depth_mm) {
    return (depth_mm + this.above_mm) * this.px_per_mm;
  }

  /** Share of the tube's bend that the catheter fills. */
  bendShare(tip_mm) {
    if (tip_mm >= -this.straight_mm) return 1;
    if (this.boundary_mm === null || this.boundary_mm >= -this.straight_mm) return 0;
    return Math.max((tip_mm - this.boundary_mm) / (-this.straight_mm - this.boundary_mm), 0);
  }

  update(state) {
    this.last = state;
    if (!this.svg) return;
    const { parts } = this;
    this.head(state);
    const tip_mm = state.is_inside === false ? null : state.tip_mm;
    const share = tip_mm === null ? 0 : this.bendShare(tip_mm);
    mark(parts.bend, "stroke-dasharray", `${share.toFixed(3)} 2`);
    const isSeen = tip_mm !== null && tip_mm >= -this.straight_mm;
    const tip_px = isSeen ? this.y_px(tip_mm) : -50;
    mark(parts.straight, "d", isSeen ? `M ${this.centre_px},${this.from_px} V ${(tip_px - TIP_PX).toFixed(1)}` : "");
    mark(parts.tip, "cy", (tip_px - TIP_PX).toFixed(1));
    mark(parts.contact, "cy", state.contact && isSeen ? (tip_px - TIP_PX).toFixed(1) : "-50");
    const right_px = this.centre_px + LABEL_PX;
    mark(parts.arrow, "d", isSeen ? `M ${right_px - 20},${tip_px.toFixed(1)} l 20,-9 v 18 z` : "");
    this.range(state, tip_mm);
    mark(this.svg, "data-suction", state.valve_open === true);
    this.secretions(isSeen && state.secretions === COMING, tip_px);
  }

  /** Where the head stands on its way, and how far the catheter reaches in the conduit. */
  head(state) {
    const { head, pushed, conduit } = this.parts;
    const { park_head_mm, head_most_mm } = this.context.machine?.anatomy || {};
    const [home_px, in_px] = [Number(head.dataset.homePx), Number(head.dataset.inPx)];
    const share = (state.head_mm - park_head_mm) / (head_most_mm - park_head_mm);
    const isKnown = state.head_mm !== null && Number.isFinite(share);
    mark(head, "visibility", isKnown ? "visible" : "hidden");
    mark(conduit, "stroke-dasharray", `${state.is_inside === false ? OUT_SHARE : 1} 2`);
    if (!isKnown) return;
    const x_px = (home_px + Math.min(Math.max(share, 0), 1) * (in_px - home_px)).toFixed(1);
    mark(head, "transform", `translate(${x_px},0)`);
    mark(pushed, "d", `M ${x_px},-44 H 226`);
  }

  /** What the line tells to come: drops at the tip, and what flows off in the catheter. */
  secretions(isComing, tip_px) {
    const { secretions, flow } = this.parts;
    mark(secretions, "visibility", isComing ? "visible" : "hidden");
    if (isComing) mark(secretions, "transform", `translate(${this.centre_px},${tip_px.toFixed(1)})`);
    mark(flow, "d", isComing ? `M ${this.centre_px},${(tip_px - TIP_PX).toFixed(1)} V ${this.from_px}` : "");
  }

  /** Where the tip may be: it is known to be between two depths. */
  range(state, tip_mm) {
    const isKnown = tip_mm !== null && state.tip_low_mm !== null && state.tip_high_mm !== null;
    const from_mm = isKnown ? Math.max(state.tip_low_mm, -this.straight_mm) : 0;
    const height_px = isKnown ? Math.max(this.y_px(state.tip_high_mm) - this.y_px(from_mm), 0) : 0;
    mark(this.parts.range, "y", this.y_px(from_mm).toFixed(1));
    mark(this.parts.range, "height", height_px.toFixed(1));
  }
}
