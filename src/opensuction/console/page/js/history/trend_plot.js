// Plots of trends; lines, axes and colours are those of a report's plots.

import uPlot from "../../vendor/uPlot.js";
import parts from "../../vendor/plot_parts.js";
import { text } from "../text.js";
import { number } from "../words.js";

const HEIGHT_PX = 190;
const DAY_S = 86400;
const BAR = 0.7; // of a day
const HUES = { completed: "good", aborted: "bad", interrupted: "notice", running: "soft" };

/** Noon of a day, UTC: plots count days, not hours. */
const at = (day) => Date.parse(`${day}T12:00:00Z`) / 1000;

/** All days from the first to the last; those without a cycle are gaps. */
function whole(days) {
  const known = new Map(days.map((day) => [day.day, day]));
  const times = [];
  for (let time = at(days[0].day); time <= at(days[days.length - 1].day); time += DAY_S) times.push(time);
  return { times, of: (time) => known.get(new Date(time * 1000).toISOString().slice(0, 10)) };
}

const dayWords = (time) => new Date(time * 1000).toLocaleDateString([], { timeZone: "UTC", day: "numeric", month: "short" });

function options(place, times, series, values) {
  return {
    width: Math.max(place.clientWidth, 200),
    height: HEIGHT_PX,
    tzDate: (time) => uPlot.tzDate(new Date(time * 1000), "UTC"),
    scales: { x: { time: true, range: [times[0] - DAY_S, times[times.length - 1] + DAY_S] }, ...values.scales },
    cursor: { y: false, drag: { x: false, y: false } },
    legend: { live: true },
    series: [{ label: text.history.trends.day, value: (_, time) => (time === null || time === undefined ? "" : dayWords(time)) }, ...series],
    axes: [
      parts.axis("", { size: 30, labelSize: 0, space: 70, incrs: [1, 2, 7, 14, 30, 91].map((days) => days * DAY_S), values: (_, splits) => splits.map(dayWords) }),
      parts.axis("", { size: 46, labelSize: 0, ...values.axis }),
    ],
    bands: values.bands,
    hooks: { ready: [parts.followTouch] },
  };
}

/** Cycles of each day, by outcome, one above the other. */
export function drawOutcomes(place, days) {
  const { times, of } = whole(days);
  const names = Object.keys(HUES).filter((name) => days.some((day) => day.outcomes[name]));
  const counts = names.map((name) => times.map((time) => of(time)?.outcomes[name] ?? 0));
  // What stands above another is drawn first and as high as both: uPlot knows no stacks.
  const heights = counts.map((_, i) => times.map((_time, at_) => counts.slice(0, i + 1).reduce((sum, one) => sum + one[at_], 0)));
  const bars = uPlot.paths.bars({ size: [BAR, 40] });
  const series = names.map((name, i) => ({
    label: text.history.outcomes[name],
    stroke: parts.colour(HUES[name]),
    fill: parts.colour(HUES[name]),
    paths: bars,
    points: { show: false },
    value: (u, _, __, index) => (index === null || index === undefined ? "" : String(counts[i][index])),
  })).reverse();
  const highest = Math.max(...(heights.at(-1) ?? [1]));
  const values = { scales: { y: { range: [0, Math.max(highest * 1.1, 1)] } }, axis: { incrs: [1, 2, 5, 10, 20, 50, 100, 200], values: (_, splits) => splits.map((one) => String(one)) } };
  return new uPlot(options(place, times, series, values), [times, ...heights.slice().reverse()], place);
}

/** A quantity's median of each day, shaded from its lowest to its highest. */
export function drawQuantity(place, days, name) {
  const { times, of } = whole(days);
  const [title, unit, decimals] = text.history.trends.quantities[name];
  const pick = (key) => times.map((time) => of(time)?.quantities[name]?.[key] ?? null);
  const shown = (_, value) => (value === null || value === undefined ? "" : `${number(value, decimals)} ${unit}`.trim());
  const hue = parts.colour("accent");
  const edge = { stroke: "transparent", points: { show: false }, spanGaps: true, value: shown };
  const series = [
    { label: title, stroke: hue, width: 2, spanGaps: true, points: { show: true, size: 7, fill: hue }, value: shown },
    { label: "", ...edge, class: "edge" },
    { label: "", ...edge, class: "edge" },
  ];
  const values = { bands: [{ series: [2, 3], fill: `color-mix(in srgb, ${hue} 22%, transparent)` }], scales: { y: { range: (_, low, high) => spanOf(low, high, decimals) } } };
  return new uPlot(options(place, times, series, values), [times, pick("median"), pick("highest"), pick("lowest")], place);
}

/** Room around values; those that are all one do not fill a plot with their last digit. */
function spanOf(low, high, decimals) {
  const least = 10 ** (1 - decimals);
  const room = Math.max(0.15 * (high - low), least);
  return [low >= 0 ? Math.max(low - room, 0) : low - room, high + room];
}

/** Draw, and again whenever width or colours change; gives what takes the plots away. */
export function keepDrawn(element, drawAll) {
  let plots = drawAll();
  let width = element.clientWidth;
  let pending = 0;
  const anew = () => {
    plots.forEach((plot) => plot.destroy());
    plots = drawAll();
  };
  const watch = new ResizeObserver(() => {
    cancelAnimationFrame(pending);
    pending = requestAnimationFrame(() => {
      if (element.clientWidth === width) return;
      width = element.clientWidth;
      anew();
    });
  });
  watch.observe(element);
  const theme = new MutationObserver(anew);
  theme.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
  return () => {
    watch.disconnect();
    theme.disconnect();
    cancelAnimationFrame(pending);
    plots.forEach((plot) => plot.destroy());
  };
}
