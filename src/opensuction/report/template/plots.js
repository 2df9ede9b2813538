"use strict";
/* Draws the plots of the page from the JSON element "data". Needs uPlot; talks to nobody. */
(() => {
  const page = JSON.parse(document.getElementById("data").textContent);
  const series = page.series;
  if (!series.time) return;

  const NARROW_PX = 560; // below this the page is on a phone: less room for plots
  const NARROW_HEIGHT_PX = 240;
  const SECOND_AXIS_PX = 62; // kept free where there is none, so that all times line up
  const DEPTH_HEADROOM = 0.13; // room above the cap, for its name and the phases', over the span
  const NARROW_HEADROOM = 0.28;
  const { axis, colour, fromZero, level, line, mark, second } = parts;
  const sync = uPlot.sync("cycle");
  let plots = [];
  let markLoop = () => {};
  let focused = page.is_quiet_after; // the machine's plots show the cycle alone, not the whole record
  let machine = []; // its plots

  const scaled = (values, factor) => values && values.map((value) => (value == null ? null : factor * value));
  series.valve_percent = scaled(series.valve, 100);
  const touched = (series.contact || []).some((force) => force > 0);
  const dashed = { dash: (u, i) => (u.series[i].dash ? "dashed" : "solid") };

  /* Faults and alarms across every plot, named under the phases of the first. */
  function markInstants(u, named) {
    page.instants.forEach(([label, hue, time], i) => mark(u, time, named ? label : "", hue, i + 1));
  }

  /* One plot of lines of data (the machine's or the patient's series) over time. */
  function timePlot(id, height, data, lines, axes, more = {}) {
    const element = document.getElementById(id);
    const known = lines.filter((entry) => data[entry.key]);
    element.closest("figure").hidden = !known.length;
    if (!known.length) return;
    const width = parts.widthOf(element);
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
        draw: [...(more.draw ? [more.draw] : []), (u) => markInstants(u, more.named)],
        setCursor: data === series ? [(u) => markLoop(u.cursor.idx)] : [],
        ready: [parts.followTouch],
      },
    };
    const plot = new uPlot(options, [data.time, ...known.map((entry) => data[entry.key])], element);
    plots.push(plot);
    if (data === series) machine.push(plot);
  }

  function depthLevel(u, depth_mm, name, ...where) {
    if (depth_mm != null) level(u, "y", depth_mm, `${name} ${Number(depth_mm.toFixed(1))} mm`, ...where);
  }

  function drawDepth() {
    const narrow = parts.widthOf(document.getElementById("depth")) < NARROW_PX;
    const headroom = narrow ? NARROW_HEADROOM : DEPTH_HEADROOM;
    timePlot("depth", 400, series, [
      line("tip", "Tip", "mm", 1, "tip", { width: 3 }),
      line("estimated", "Tip, estimated", "mm", 1, series.tip ? "removed" : "tip", { width: series.tip ? 1.5 : 3 }),
      line("reference", "Desired tip", "mm", 1, "reference", { width: 1.5, dash: [7, 4] }),
      line("head", "Head", "mm", 1, "head", { width: 1.5 }),
      line("deepest", "Deepest possible", "mm", 1, "deepest", { width: 1.5, dash: [2, 3] }),
    ], [axis("mm below the tube's end")], {
      named: true,
      scales: { y: { range: (_, low, high) => {
        const [bottom, top] = [Math.min(low, 0) - 5, Math.max(high, page.cap_mm || 0)];
        return [bottom, top + headroom * (top - bottom)];
      } } },
      draw: (u) => {
        depthLevel(u, page.cap_mm, page.cap_name, page.cap_name === "Cap" ? "bad" : "soft", "above");
        depthLevel(u, page.target_mm, "Target", "soft", "below");
        if (!page.boundary_mm) return; // the bench's patient begins where the tube ends
        level(u, "y", 0, "Tube's end", "soft", "below", "center"); // the tip is elsewhere then
        depthLevel(u, page.boundary_mm, "Patient begins", "soft", "above", "center");
      },
    });
  }

  function drawError() {
    timePlot("error", 220, series, [line("error", "Tip minus desired", "mm", 2, "tip", { width: 1.5 })],
      [axis("mm")], { draw: (u) => level(u, "y", 0, "", "soft", "above") });
  }

  function drawSuction() {
    timePlot("suction", 280, series, [
      line("valve_percent", "Valve open", "%", 0, "valve", { scale: "ratio", fill: colour("valve") + "30" }),
      line("line_vacuum", "Line vacuum", "mmHg", 0, "line-vacuum", { width: 2.5 }),
      line("tip_vacuum", "Tip vacuum", "mmHg", 0, "tip-vacuum", { dash: [6, 3], width: 1.5 }),
    ], [axis("Vacuum (mmHg)"), second("Valve open (%)", "ratio")], {
      scales: { ratio: { range: [0, 105] }, y: fromZero(1.15, 10) },
      draw: (u) => level(u, "y", page.setpoint_mmhg, "Set to " + page.setpoint_mmhg + " mmHg", "soft", "below", "left"),
    });
  }

  function drawSecretion() {
    timePlot("secretion", 200, series, [
      line("removed", "Removed", "mL", 2, "removed", { fill: colour("removed") + "30" }),
    ], [axis("mL")], { scales: { y: fromZero(1.1, 0.5) } });
  }

  function drawContact() {
    const force = line("contact", "Force at the carina", "N", 3, "contact", { fill: colour("contact") + "30" });
    timePlot("contact", 200, series, touched ? [force] : [], [axis("N")], { scales: { y: fromZero(1.2, 0.1) } });
  }

  function drawPatient() {
    if (page.patient.time) patientPlots.forEach((draw) => draw(timePlot, page.patient));
  }

  function drawLoop() {
    const element = document.getElementById("loop");
    element.closest("section").hidden = !(series.head && series.tip);
    if (!series.head || !series.tip) return;
    const loop = loopPlot(element, series, parts.widthOf(element));
    markLoop = loop.mark;
    plots.push(loop.plot);
  }

  /* Show the whole record, or the cycle alone. */
  function frame() {
    for (const [id, value] of [["whole", false], ["focus", true]])
      document.getElementById(id).setAttribute("aria-pressed", String(value === focused));
    for (const u of machine) {
      const times = u.data[0];
      const end = times[times.length - 1];
      u.setScale("x", { min: times[0], max: focused ? Math.min(page.focus_s ?? end, end) : end });
    }
  }

  function followButtons() {
    for (const [id, value] of [["whole", false], ["focus", true]])
      document.getElementById(id).addEventListener("click", () => {
        focused = value;
        frame();
      });
  }

  function drawAll() {
    plots.forEach((plot) => plot.destroy());
    plots = [];
    machine = [];
    markLoop = () => {};
    for (const draw of [drawDepth, drawError, drawSuction, drawContact, drawSecretion, drawLoop, drawPatient]) draw();
    frame();
  }

  followButtons();
  parts.keepDrawn(drawAll);
})();
