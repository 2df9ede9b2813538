"use strict";
/* The patient over time, also after the cycle: airway pressure, lung volume, oxygen saturation. */
const patientPlots = (() => {
  const PRESSURE_MARGIN_CMH2O = 2;
  const VOLUME_MARGIN_ML = 60;
  const LEAST_LOSS_ML = 50; // a smaller loss shall not look like a large one
  const RATE_MARGIN = 8; // heart rate, a minute
  const LEAST_SPAN_PERCENT = 5; // nor a fall of saturation
  const { axis, level, line } = parts;

  const least = (values) => values.reduce((low, value) => Math.min(low, value ?? low), Infinity);

  function airwayPressure(timePlot, patient) {
    timePlot("airway", 240, patient, [
      line("airway_pressure", "Airway pressure", "cmH2O", 1, "airway", { width: 1.5 }),
    ], [axis("cmH2O")], {
      named: true,
      scales: { y: { range: (_, low, high) =>
        [Math.min(low, 0) - PRESSURE_MARGIN_CMH2O, high + 2 * PRESSURE_MARGIN_CMH2O] } },
      draw: (u) => level(u, "y", 0, "", "soft", "above"),
    });
  }

  function lungVolume(timePlot, patient) {
    timePlot("lung", 260, patient, [
      line("lung_volume", "Lung volume", "mL", 0, "lung", { width: 1.5 }),
      line("lung_volume_loss", "Resting volume lost", "mL", 0, "loss", { scale: "loss", dash: [6, 3] }),
    ], [axis("Volume (mL)"), parts.second("Lost (mL)", "loss")], {
      scales: {
        y: { range: (_, low, high) => [low - VOLUME_MARGIN_ML, high + VOLUME_MARGIN_ML] },
        loss: parts.fromZero(1.15, LEAST_LOSS_ML),
      },
    });
  }

  function saturation(timePlot, patient) {
    const lowest = patient.spo2 && least(patient.spo2);
    timePlot("saturation", 240, patient, [
      line("spo2", "Oxygen saturation", "%", 1, "spo2", { width: 2.5 }),
    ], [axis("SpO2 (%)")], {
      scales: { y: { range: (_, low, high) => {
        const top = Math.min(100.5, high + 1);
        return [Math.min(low - 1, top - LEAST_SPAN_PERCENT), top];
      } } },
      draw: (u) => Number.isFinite(lowest) &&
        level(u, "y", lowest, "Lowest " + lowest.toFixed(1) + " %", "soft", "below", "left"),
    });
  }

  function heartRate(timePlot, patient) {
    timePlot("heart", 200, patient, [
      line("heart_rate", "Heart rate", "/min", 0, "contact", { width: 2 }),
    ], [axis("Heart rate (/min)")], {
      scales: { y: { range: (_, low, high) => [Math.max(low - RATE_MARGIN, 0), high + RATE_MARGIN] } },
    });
  }

  return [airwayPressure, lungVolume, saturation, heartRate];
})();
