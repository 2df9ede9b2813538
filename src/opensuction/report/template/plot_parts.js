"use strict";
/* What every plot of the page shares: colours, lines, axes, phase shading, named levels. */
const parts = (() => {
  const PRINT_PX = 680; // width of a plot on A4 and Letter
  const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif';

  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
  const shown = (unit, decimals) => (_, value) =>
    value == null ? "" : value.toFixed(decimals) + " " + unit;

  /* One line of a plot: where its values are, its name with the unit, colour variable, dash. */
  const line = (key, label, unit, decimals, hue, more = {}) => ({
    key, label, value: shown(unit, decimals), stroke: colour(hue), width: 2,
    points: { show: false }, ...more,
  });

  const axis = (label, more = {}) => ({
    label, font: FONT, labelFont: FONT, stroke: colour("soft"), labelSize: 18, labelGap: 2,
    grid: { stroke: colour("line"), width: 1 }, ticks: { stroke: colour("line"), width: 1, size: 5 },
    size: 44, ...more,
  });

  const second = (label, scale) => axis(label, { scale, side: 1, grid: { show: false } });
  const fromZero = (margin, least) => ({ range: (_, low, high) => [0, margin * Math.max(high, least)] });

  /* Shade the phases behind everything; name them along the top where there is room. */
  function shadePhases(u, phases, named) {
    const { ctx, bbox } = u;
    const ratio = uPlot.pxRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.font = FONT.replace("12px", 11 * ratio + "px");
    ctx.textBaseline = "top";
    for (const [label, kind, start, end] of phases) {
      const from = u.valToPos(start, "x", true);
      const to = u.valToPos(end, "x", true);
      ctx.globalAlpha = 0.16;
      ctx.fillStyle = colour(kind);
      ctx.fillRect(from, bbox.top, to - from, bbox.height);
      ctx.globalAlpha = 1;
      if (named && ctx.measureText(label).width + 10 * ratio < to - from) {
        ctx.fillStyle = colour("soft");
        ctx.fillText(label, from + 5 * ratio, bbox.top + 4 * ratio);
      }
    }
    ctx.restore();
  }

  /* A dashed horizontal with its name; "above" or "below" the line, "left", "center" or "right". */
  function level(u, scale, value, name, hue, side, edge = "right") {
    if (value == null) return;
    const { ctx, bbox } = u;
    const ratio = uPlot.pxRatio;
    const y = u.valToPos(value, scale, true);
    if (y < bbox.top || y > bbox.top + bbox.height) return;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colour(hue);
    ctx.lineWidth = 1.5 * ratio;
    ctx.setLineDash([7 * ratio, 5 * ratio]);
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    ctx.font = FONT.replace("12px", 12 * ratio + "px");
    ctx.textAlign = edge;
    ctx.textBaseline = side === "above" ? "bottom" : "top";
    const x = bbox.left + { left: 4 * ratio, center: bbox.width / 2, right: bbox.width - 4 * ratio }[edge];
    ctx.fillText(name, x, y + (side === "above" ? -3 : 3) * ratio);
    ctx.restore();
  }

  /* An upright line at an instant; neighbours' names stand below one another. */
  function mark(u, value, name, hue, row) {
    const { ctx, bbox } = u;
    const ratio = uPlot.pxRatio;
    const x = u.valToPos(value, "x", true);
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colour(hue);
    ctx.lineWidth = 1.5 * ratio;
    ctx.setLineDash([]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.font = FONT.replace("12px", 12 * ratio + "px");
    ctx.textBaseline = "top";
    const late = x > bbox.left + 0.7 * bbox.width;
    ctx.textAlign = late ? "right" : "left";
    const at = [x + (late ? -4 : 4) * ratio, bbox.top + (3 + 15 * row) * ratio];
    ctx.strokeStyle = colour("paper"); // a name stays readable where it crosses a curve
    ctx.lineWidth = 4 * ratio;
    ctx.lineJoin = "round";
    ctx.strokeText(name, ...at);
    ctx.fillText(name, ...at);
    ctx.restore();
  }

  /* Fingers have no hover: a touch moves the cursor of all plots, a swipe still scrolls. */
  function followTouch(u) {
    const move = (event) => {
      const box = u.over.getBoundingClientRect();
      const touch = event.touches[0];
      u.setCursor({ left: touch.clientX - box.left, top: touch.clientY - box.top }, true, true);
    };
    u.over.addEventListener("touchstart", move, { passive: true });
    u.over.addEventListener("touchmove", move, { passive: true });
  }

  let printing = false;
  /* Width to draw at: the element's, or the sheet of paper's (a share of it for plots abreast). */
  const widthOf = (element, share = 1) => (printing ? PRINT_PX * share : element.clientWidth);

  /* Draw now, and again whenever the page's width or colours change or it is printed. */
  function keepDrawn(drawAll) {
    const print = (on) => {
      printing = on;
      document.documentElement.toggleAttribute("data-print", on);
      drawAll();
    };
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
  }

  return { widthOf, keepDrawn, colour, line, axis, second, fromZero, shadePhases, level, mark, followTouch };
})();
