"use strict";
/* Draws the plots of a sheet from the JSON element "data". Needs uPlot; talks to nobody. */
(() => {
  const page = JSON.parse(document.getElementById("data").textContent);
  const HEIGHT_PX = 300;
  const NARROW_PX = 480; // a phone: less room
  const NARROW_HEIGHT_PX = 240;
  const MARGIN = 0.05; // of what the curves span, around them
  const { axis, colour, level, mark, shadePhases } = parts;
  let plots = [];

  const extent = (values) => values.reduce(([low, high], value) =>
    value == null ? [low, high] : [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  const padded = (_, low, high) => {
    if (low == null) return [0, 1];
    const room = MARGIN * (high - low || Math.abs(high) || 1);
    return [low - room, high + room];
  };
  const shown = (_, value) => (value == null ? "" : String(Number(value.toPrecision(4))));
  const looks = (curve) => ({
    label: curve.label, stroke: colour(curve.hue), width: 2, dash: curve.dashed ? [7, 4] : undefined,
    points: { show: false }, value: shown,
  });

  /* A loop is no function of its abscissa: such curves are drawn by hand on uPlot's axes. */
  function trace(u, curve) {
    const { ctx } = u;
    const ratio = uPlot.pxRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    ctx.clip();
    ctx.strokeStyle = colour(curve.hue);
    ctx.lineWidth = 2 * ratio;
    ctx.lineJoin = "round";
    ctx.setLineDash(curve.dashed ? [7 * ratio, 4 * ratio] : []);
    ctx.beginPath();
    let drawing = false;
    curve.x.forEach((x, i) => {
      if (x == null || curve.y[i] == null) { drawing = false; return; }
      const at = [u.valToPos(x, "x", true), u.valToPos(curve.y[i], "y", true)];
      if (drawing) ctx.lineTo(...at); else ctx.moveTo(...at);
      drawing = true;
    });
    ctx.stroke();
    ctx.restore();
  }

  /* The labels of curves drawn by hand: uPlot's legend knows only its own series. */
  function key(element, curves) {
    const list = document.createElement("p");
    list.className = "keys";
    for (const curve of curves) {
      const mark = document.createElement("i");
      mark.className = "line" + (curve.dashed ? " dashed" : "");
      mark.style.borderTopColor = colour(curve.hue);
      list.append(mark, " " + curve.label + "  ");
    }
    element.append(list);
  }

  /* What is folded has no width to draw in: it is drawn when it is opened. */
  const isFolded = (element) => element.closest("details:not([open])") !== null;

  function draw(id, plot) {
    const element = document.getElementById(id);
    if (isFolded(element)) return;
    element.replaceChildren();
    const width = parts.widthOf(element);
    if (plot.lanes.length) {
      plots.push(lanes.draw(element, plot, width));
      return;
    }
    const height = width < NARROW_PX ? NARROW_HEIGHT_PX : HEIGHT_PX;
    const levels = (u) => {
      plot.levels.forEach(({ value, name }) => level(u, "y", value, name, "soft", "above"));
      const below = plot.shades.length ? 1 : 0; // the names of what is shaded are on top
      plot.marks.forEach(({ value, name }, i) => mark(u, value, name, "fault", i + below));
    };
    const shades = (u) => shadePhases(u, plot.shades, true);
    const range = plot.span ?? undefined;
    const common = {
      width, height,
      scales: { x: { time: false, range }, y: { range: padded } },
      axes: [axis(plot.x_label, { size: 32 }), axis(plot.y_label, { size: 56 })],
    };
    if (plot.x) {
      plots.push(new uPlot({
        ...common,
        cursor: { y: false },
        series: [{ label: plot.x_label, value: shown }, ...plot.curves.map(looks)],
        hooks: { drawClear: [shades], draw: [levels], ready: [parts.followTouch] },
      }, [plot.x, ...plot.curves.map((curve) => curve.y)], element));
      return;
    }
    const spans = ["x", "y"].map((name) => extent(plot.curves.flatMap((curve) => curve[name])));
    plots.push(new uPlot({
      ...common,
      scales: { x: { time: false, range: range ?? padded }, y: { range: padded } },
      cursor: { show: false }, legend: { show: false },
      series: [{}, { stroke: "transparent", points: { show: false } }],
      hooks: { drawClear: [shades], draw: [(u) => plot.curves.forEach((curve) => trace(u, curve)), levels] },
    }, spans, element));
    key(element, plot.curves);
  }

  function drawAll() {
    plots.forEach((plot) => plot.destroy());
    plots = [];
    for (const [id, plot] of Object.entries(page)) draw(id, plot);
  }

  function drawIn(details) {
    if (!details.open) return;
    for (const [id, plot] of Object.entries(page)) {
      const element = document.getElementById(id);
      if (details.contains(element) && !element.firstChild) draw(id, plot);
    }
  }

  function openTarget() {
    const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!(target instanceof HTMLDetailsElement)) return;
    target.open = true;
    target.scrollIntoView();
  }

  document.querySelectorAll("details").forEach((details) =>
    details.addEventListener("toggle", () => drawIn(details)));
  addEventListener("hashchange", openTarget);
  parts.keepDrawn(drawAll);
  openTarget();
})();
