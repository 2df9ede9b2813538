"use strict";
/* Tip against head. A loop is no function of the head, so it is drawn by hand on uPlot's axes. */
const loopPlot = (() => {
  const ARROW_ROWS = 20; // rows back from which an arrow takes its direction: past the jitter
  const MARGIN_MM = 4;

  const hue = (inward) => parts.colour(inward ? "inward" : "outward");
  const moves = (series, row, inward) => series.inward[row] === (inward ? 1 : 0);
  const extent = (values) => values.reduce(([low, high], value) =>
    [Math.min(low, value ?? low), Math.max(high, value ?? high)], [Infinity, -Infinity]);

  function stroke(u, series, inward) {
    const { ctx } = u;
    const ratio = uPlot.pxRatio;
    const at = (row) => [u.valToPos(series.head[row], "x", true), u.valToPos(series.tip[row], "y", true)];
    ctx.strokeStyle = hue(inward);
    ctx.setLineDash(inward ? [] : [8 * ratio, 5 * ratio]);
    ctx.beginPath();
    for (let row = 1; row < series.time.length; row++) {
      if (!moves(series, row, inward)) continue;
      if (row === 1 || !moves(series, row - 1, inward)) ctx.moveTo(...at(row - 1));
      ctx.lineTo(...at(row));
    }
    ctx.stroke();
    ctx.setLineDash([]);
  }

  /* An arrow head half way along the way in or out. */
  function arrow(u, series, inward) {
    const { ctx } = u;
    const size = 9 * uPlot.pxRatio;
    const [low, high] = extent(series.tip);
    const half = (low + high) / 2;
    const row = series.tip.findIndex((tip, i) => i > 0 && moves(series, i, inward) &&
      tip !== series.tip[i - 1] && (series.tip[i - 1] - half) * (tip - half) <= 0);
    if (row < 0) return;
    const from = Math.max(row - ARROW_ROWS, 0);
    const x = u.valToPos(series.head[row], "x", true);
    const y = u.valToPos(series.tip[row], "y", true);
    ctx.save();
    ctx.translate(x, y);
    ctx.rotate(Math.atan2(y - u.valToPos(series.tip[from], "y", true),
      x - u.valToPos(series.head[from], "x", true)));
    ctx.fillStyle = hue(inward);
    ctx.beginPath();
    ctx.moveTo(size, 0);
    ctx.lineTo(-size, size * 0.8);
    ctx.lineTo(-size, -size * 0.8);
    ctx.fill();
    ctx.restore();
  }

  function drawn(u, series) {
    u.ctx.save();
    u.ctx.lineWidth = 2.5 * uPlot.pxRatio;
    u.ctx.lineJoin = "round";
    for (const inward of [true, false]) stroke(u, series, inward);
    for (const inward of [true, false]) arrow(u, series, inward);
    u.ctx.restore();
  }

  /* Draws into the element; returns the plot and mark(row), which rings one row or none. */
  return (element, series, width) => {
    const plot = new uPlot({
      width, height: Math.round(Math.min(460, 0.8 * width)),
      scales: { x: { time: false, range: (_, low, high) => [low - MARGIN_MM, high + MARGIN_MM] } },
      cursor: { show: false }, legend: { show: false },
      series: [{}, { stroke: "transparent", points: { show: false } }],
      axes: [parts.axis("Head (mm)", { size: 32 }), parts.axis("Tip (mm below the tube's end)")],
      hooks: { draw: [(u) => drawn(u, series)] },
    }, [extent(series.head), extent(series.tip)], element);
    const ring = plot.over.appendChild(document.createElement("div"));
    ring.className = "ring-mark";
    const mark = (row) => {
      ring.style.display = row == null ? "none" : "block";
      if (row == null) return;
      ring.style.left = plot.valToPos(series.head[row], "x") + "px";
      ring.style.top = plot.valToPos(series.tip[row], "y") + "px";
    };
    return { plot, mark };
  };
})();
