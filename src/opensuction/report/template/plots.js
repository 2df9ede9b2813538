"use strict";
/* Draws the plots of the page from the JSON element "data". Needs uPlot; talks to nobody. */
(() => {
  const page = JSON.parse(document.getElementById("data").textContent);
  const series = page.series;
  if (!series.time) return;

  const NARROW_PX = 560; // below this the page is on a phone: less room for plots
  const NARROW_HEIGHT_PX = 240;
  const SECOND_AXIS_PX = 62; // kept free where there is none, so that all times line up
  const DEPTH_HEADROOM = 1.15; // room above the cap for the names of the phases
  const PRINT_PX = 680; // width of a plot on A4 and Letter
  const { axis, colour, level, line } = parts;
  const sync = uPlot.sync("cycle");
  let plots = [];
  let markLoop = () => {};
  let printing = false;

  const scaled = (values, factor) => values && values.map((value) => (value == null ? null : factor * value));
  series.valve_percent = scaled(series.valve, 100);
  const touched = (series.contact || []).some((force) => force > 0);
  const widthOf = (element) => (printing ? PRINT_PX : element.clientWidth);
  const dashed = { dash: (u, i) => (u.series[i].dash ? "dashed" : "solid") };
  const second = (label, scale) => axis(label, { scale, side: 1, grid: { show: false } });
  const fromZero = (margin, least) => ({ range: (_, low, high) => [0, margin * Math.max(high, least)] });

  function timePlot(id, height, lines, axes, more = {}) {
    const element = document.getElementById(id);
    const known = lines.filter((entry) => series[entry.key]);
    element.closest("figure").hidden = !known.length;
    if (!known.length) return;
    const width = widthOf(element);
    const options = {
      width, padding: [null, axes.length > 1 || width < NARROW_PX ? null : SECOND_AXIS_PX, null, null],
      height: width < NARROW_PX ? Math.min(height, NARROW_HEIGHT_PX) : height,
      scales: { x: { time: false }, ...more.scales },
      cursor: { sync: { key: sync.key }, y: false, drag: { x: true, y: false } },
      legend: { markers: dashed },
      series: [{ label: "Time", value: (_, time) => (time == null ? "" : time.toFixed(2) + " s") }, ...known],
      axes: [axis("Time (s)", { size: 32 }), ...axes],
      hooks: {
        drawClear: [(u) => parts.shadePhases(u, page.phases, more.named)],
        draw: more.draw ? [more.draw] : [],
        setCursor: [(u) => markLoop(u.cursor.idx)],
        ready: [parts.followTouch],
      },
    };
    plots.push(new uPlot(options, [series.time, ...known.map((entry) => series[entry.key])], element));
  }

  function drawDepth() {
    timePlot("depth", 400, [
      line("tip", "Tip", "mm", 1, "tip", { width: 3 }),
      line("reference", "Desired tip", "mm", 1, "reference", { width: 1.5, dash: [7, 4] }),
      line("head", "Head", "mm", 1, "head", { width: 1.5 }),
      line("deepest", "Deepest possible", "mm", 1, "deepest", { width: 1.5, dash: [2, 3] }),
    ], [axis("mm below the tube's end")], {
      named: true,
      scales: { y: { range: (_, low, high) =>
        [Math.min(low, 0) - 5, Math.max(high, page.cap_mm || 0) * DEPTH_HEADROOM] } },
      draw: (u) => {
        level(u, "y", page.cap_mm, "Cap " + page.cap_mm + " mm", "bad", "above");
        level(u, "y", page.target_mm, "Target " + page.target_mm + " mm", "soft", "below");
      },
    });
  }

  function drawError() {
    timePlot("error", 220, [line("error", "Tip minus desired", "mm", 2, "tip", { width: 1.5 })],
      [axis("mm")], { draw: (u) => level(u, "y", 0, "", "soft", "above") });
  }

  function drawSuction() {
    timePlot("suction", 280, [
      line("valve_percent", "Valve open", "%", 0, "valve", { scale: "ratio", fill: colour("valve") + "30" }),
      line("line_vacuum", "Line vacuum", "mmHg", 0, "line-vacuum", { width: 2.5 }),
      line("tip_vacuum", "Tip vacuum", "mmHg", 0, "tip-vacuum", { dash: [6, 3], width: 1.5 }),
    ], [axis("Vacuum (mmHg)"), second("Valve open (%)", "ratio")], {
      scales: { ratio: { range: [0, 105] }, y: fromZero(1.15, 10) },
      draw: (u) => level(u, "y", page.setpoint_mmhg, "Set to " + page.setpoint_mmhg + " mmHg", "soft", "below", "left"),
    });
  }

  function drawSecretion() {
    const force = [line("contact", "Force on the carina", "N", 2, "contact", { scale: "force" })];
    timePlot("secretion", 200, [
      line("removed", "Removed", "mL", 2, "removed", { fill: colour("removed") + "30" }),
      ...(touched ? force : []),
    ], [axis("mL"), ...(touched ? [second("N", "force")] : [])],
      { scales: { y: fromZero(1.1, 0.5), ...(touched ? { force: fromZero(1.2, 0.1) } : {}) } });
  }

  function drawLoop() {
    const element = document.getElementById("loop");
    element.closest("section").hidden = !(series.head && series.tip);
    if (!series.head || !series.tip) return;
    const loop = loopPlot(element, series, widthOf(element));
    markLoop = loop.mark;
    plots.push(loop.plot);
  }

  function drawAll() {
    plots.forEach((plot) => plot.destroy());
    plots = [];
    markLoop = () => {};
    for (const draw of [drawDepth, drawError, drawSuction, drawSecretion, drawLoop]) draw();
  }

  function print(on) {
    printing = on;
    document.documentElement.toggleAttribute("data-print", on);
    drawAll();
  }

  let pending = 0;
  let drawnWidth = document.body.clientWidth;
  drawAll();
  addEventListener("resize", () => {
    cancelAnimationFrame(pending);
    pending = requestAnimationFrame(() => {
      if (document.body.clientWidth === drawnWidth) return; // a phone's address bar came or went
      drawnWidth = document.body.clientWidth;
      drawAll();
    });
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawAll);
  addEventListener("beforeprint", () => print(true));
  addEventListener("afterprint", () => print(false));
})();
