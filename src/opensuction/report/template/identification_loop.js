"use strict";
/* Output against input. A loop is no function of its input, so it is drawn by hand on uPlot's axes. */
const identificationLoop = (() => {
  const MARGIN = 0.03; // room around the loop, as a share of its extent

  function extent(lists) {
    let [low, high] = [Infinity, -Infinity];
    for (const list of lists) for (const value of list) {
      if (value == null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    return [low, high];
  }

  function path(u, across, up, hue, width, dash) {
    const { ctx } = u;
    ctx.strokeStyle = hue;
    ctx.lineWidth = width * uPlot.pxRatio;
    ctx.setLineDash(dash.map((length) => length * uPlot.pxRatio));
    ctx.beginPath();
    across.forEach((value, row) => {
      if (value == null || up[row] == null) return;
      ctx.lineTo(u.valToPos(value, "x", true), u.valToPos(up[row], "y", true));
    });
    ctx.stroke();
  }

  const less = (values, line) => values.map((value, row) => (value == null ? null : value - line[row]));

  /* Draws into the element what is measured and, above it, the models that are shown; with bare,
     all of it less the straight line through the recording, which leaves the hysteresis alone. */
  return (element, page, shown, width, bare) => {
    const { loop } = page;
    const taken = (values) => (bare ? less(values, loop.line) : values);
    const measured = taken(loop.output);
    const fitted = shown.map((model) => taken(loop.fitted[model.name]));
    const label = bare ? page.output_label + " less line" : page.output_label;
    const widened = (_, low, high) => [low - MARGIN * (high - low), high + MARGIN * (high - low)];
    return new uPlot({
      width, height: Math.round(Math.min(520, 0.75 * width)),
      scales: { x: { time: false, range: widened }, y: { range: widened } },
      cursor: { show: false }, legend: { show: false },
      series: [{}, { stroke: "transparent", points: { show: false } }],
      axes: [parts.axis(page.input_label, { size: 32 }), parts.axis(label, { size: 56 })],
      hooks: { draw: [(u) => {
        u.ctx.save();
        u.ctx.lineJoin = "round";
        path(u, loop.input, measured, parts.colour("rest"), 5, []);
        shown.forEach((model, i) =>
          path(u, loop.input, fitted[i], parts.colour(model.hue), 1.8, model.dashed ? [6, 4] : []));
        u.ctx.restore();
      }] },
    }, [extent([loop.input]), extent([measured, ...fitted])], element);
  };
})();
