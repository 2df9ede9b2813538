"use strict";
/* Draws the plots of an identification from the JSON element "data". Needs uPlot; talks to nobody. */
(() => {
  const page = JSON.parse(document.getElementById("data").textContent);
  const NARROW_PX = 560; // below this the page is on a phone: less room for plots
  const NARROW_HEIGHT_PX = 220;
  const DIGITS = 5; // of a value under the cursor
  const { axis, colour, level, line } = parts;
  const sync = uPlot.sync("identification");
  const shown = new Set(page.models.filter((model) => model.shown).map((model) => model.name));
  let plots = [];

  const chosen = () => page.models.filter((model) => shown.has(model.name));
  const held = page.held_from == null ? [] : [["Held out", "rest", page.held_from, page.time[page.time.length - 1]]];
  const timeLabel = page.timed ? "Time (s)" : "Sample";
  const lagLabel = page.timed ? "Lag (s)" : "Lag (samples)";
  const read = (unit) => (_, value) => (value == null ? "" : `${Number(value.toPrecision(DIGITS))} ${unit}`.trim());
  const lineOf = (model, unit) => line(model.name, model.name, "", 0, model.hue,
    { width: 1.5, dash: model.dashed ? [6, 4] : undefined, value: read(unit) });

  /* One plot: an abscissa, lines with their values, a label of the ordinate. */
  function plot(id, height, across, lines, label, more = {}) {
    const element = document.getElementById(id);
    const width = parts.widthOf(element);
    plots.push(new uPlot({
      width, height: width < NARROW_PX ? Math.min(height, NARROW_HEIGHT_PX) : height,
      scales: { x: { time: false }, ...more.scales },
      cursor: { sync: more.timed ? { key: sync.key } : undefined, y: false, drag: { x: true, y: false } },
      series: [{ label: more.label, value: read("") }, ...lines.map(([entry]) => entry)],
      axes: [axis(more.label, { size: 32 }), axis(label, { size: 56 })],
      hooks: {
        drawClear: more.timed ? [(u) => parts.shadePhases(u, held, true)] : [],
        draw: more.draw ? [more.draw] : [],
        ready: [parts.followTouch],
      },
    }, [across, ...lines.map(([, values]) => values)], element));
  }

  function drawOutput() {
    const measured = line("measured", "Measured", "", 0, "rest", { width: 4, value: read(page.unit) });
    plot("output", 320, page.time,
      [[measured, page.output], ...chosen().map((model) => [lineOf(model, page.unit), page.fitted[model.name]])],
      page.output_label, { timed: true, label: timeLabel });
  }

  function drawResidual() {
    plot("residual", 260, page.time,
      chosen().map((model) => [lineOf(model, page.unit), page.rest[model.name]]),
      page.unit ? `Residual (${page.unit})` : "Residual",
      { timed: true, label: timeLabel, draw: (u) => level(u, "y", 0, "", "soft", "above") });
  }

  function drawAutocorrelation() {
    const { lag, values, band } = page.autocorrelation;
    const draw = (u) => {
      level(u, "y", band, "noise stays below", "soft", "above");
      level(u, "y", -band, "", "soft", "below");
    };
    plot("autocorrelation", 220, lag, chosen().map((model) => [lineOf(model, ""), values[model.name]]),
      "Autocorrelation", { label: lagLabel, draw, scales: { y: { range: (_, low) => [Math.min(low, -0.2), 1.02] } } });
  }

  function drawLoops() {
    for (const [id, bare] of [["loop", false], ["hysteresis", true]]) {
      const element = document.getElementById(id);
      const width = parts.widthOf(element, 0.5);
      plots.push(identificationLoop(element, page, chosen(), width, bare));
    }
  }

  function drawAll() {
    plots.forEach((drawn) => drawn.destroy());
    plots = [];
    for (const draw of [drawLoops, drawOutput, drawResidual, drawAutocorrelation]) draw();
  }

  for (const chip of document.querySelectorAll("#chips button")) {
    chip.addEventListener("click", () => {
      const name = chip.dataset.model;
      if (!shown.delete(name)) shown.add(name);
      chip.setAttribute("aria-pressed", String(shown.has(name)));
      drawAll();
    });
  }
  parts.keepDrawn(drawAll);
})();
