"use strict";
/* Draws a plot of lanes: bars and instants over one abscissa, a row for each name. Needs uPlot. */
const lanes = (() => {
  const NAME_PX = 17; // the lane's name, above its bars
  const BAR_PX = 17;
  const WORDS_PX = 15; // a row of names below bars
  const ROWS = 3; // of such names
  const GAP_PX = 9;
  const AXIS_PX = 68; // with uPlot's room above
  const FONT_PX = 12;
  const FAINT = 0.45; // opacity of a bar: words on it stay readable
  const FONT = 'px system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif';
  const { axis, colour } = parts;

  const isInstant = ([, , start, end]) => start === end;
  const heightOf = (lane) => NAME_PX + BAR_PX + GAP_PX + (lane.named ? ROWS * WORDS_PX : 0);

  /* Words below a place, in the first row where they meet no others. */
  function say(u, words, x, top, ratio, taken) {
    const { ctx, bbox } = u;
    const wide = ctx.measureText(words).width + 8 * ratio;
    const from = Math.min(x, bbox.left + bbox.width - wide);
    const row = taken.findIndex((ends) => ends <= from);
    if (row < 0) return; // the table of events has it
    taken[row] = from + wide;
    ctx.fillStyle = colour("ink");
    ctx.fillText(words, from, top + (row + 0.5) * WORDS_PX * ratio);
  }

  function drawLane(u, lane, top, ratio) {
    const { ctx, bbox } = u;
    const bars = top + NAME_PX * ratio;
    const below = bars + BAR_PX * ratio;
    const taken = Array(ROWS).fill(bbox.left - 2 * ratio); // an instant may be at the edge
    ctx.textAlign = "left";
    ctx.textBaseline = "middle";
    ctx.fillStyle = colour("soft");
    ctx.fillText(lane.name, bbox.left + 4 * ratio, top + (NAME_PX / 2) * ratio);
    for (const stretch of lane.stretches) {
      const [name, kind, start, end] = stretch;
      const x = u.valToPos(start, "x", true);
      if (lane.named) say(u, name, x, below, ratio, taken);
      ctx.fillStyle = colour(kind);
      if (isInstant(stretch)) {
        ctx.fillRect(x - ratio, bars, 2 * ratio, BAR_PX * ratio);
        continue;
      }
      const wide = Math.max(u.valToPos(end, "x", true) - x, 2 * ratio);
      ctx.globalAlpha = FAINT;
      ctx.fillRect(x, bars, wide, BAR_PX * ratio);
      ctx.globalAlpha = 1;
      ctx.fillRect(x, bars, Math.min(2 * ratio, wide), BAR_PX * ratio);
      if (lane.named || ctx.measureText(name).width + 10 * ratio > wide) continue;
      ctx.fillStyle = colour("ink");
      ctx.fillText(name, x + 6 * ratio, bars + (BAR_PX / 2) * ratio);
    }
  }

  function drawLanes(u, plot) {
    const { ctx, bbox } = u;
    const ratio = uPlot.pxRatio;
    let top = bbox.top;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.font = FONT_PX * ratio + FONT;
    for (const lane of plot.lanes) {
      drawLane(u, lane, top, ratio);
      top += heightOf(lane) * ratio;
    }
    ctx.restore();
  }

  const nothing = { values: () => [], grid: { show: false }, ticks: { show: false } };

  /* The plot in an element. Its left edge is that of the curves above it. */
  function draw(element, plot, width) {
    const height = plot.lanes.reduce((sum, lane) => sum + heightOf(lane), AXIS_PX);
    return new uPlot({
      width, height,
      scales: { x: { time: false, range: plot.span }, y: { range: [0, 1] } },
      axes: [axis(plot.x_label, { size: 32 }), axis("", { size: 56, ...nothing })],
      cursor: { show: false }, legend: { show: false },
      series: [{}, { stroke: "transparent", points: { show: false } }],
      hooks: { draw: [(u) => drawLanes(u, plot)] },
    }, [plot.span, [0, 0]], element);
  }

  return { draw };
})();
