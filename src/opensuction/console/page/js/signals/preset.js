// Channels that are looked at together.

const IN = "inputs.readings.";
const OUT = "outputs.";
const WATCH = "state.core.governor.watch.";

export const LOOP = [`${IN}carriage_mm`, `${OUT}demand.reference_mm`, "tip.high_mm", "tip.low_mm"];

export const PRESETS = {
  insertion: [
    `${IN}carriage_mm`, `${OUT}demand.reference_mm`, "tip.high_mm", "tip.low_mm",
    `${WATCH}speed_mm_per_s`, `${OUT}commands.insertion_v`, `${IN}insertion_current_a`, `${WATCH}drive.force_n`,
  ],
  suction: [
    `${IN}line_vacuum_mmhg`, `${OUT}commands.vacuum_mmhg`, `${WATCH}filter.smooth_mmhg`,
    `${IN}cam_rad`, `${OUT}commands.cam_rad`, `${OUT}commands.valve_v`, `${OUT}demand.valve_open`, `${OUT}commands.pump_on`,
  ],
  patient: [
    `${IN}monitor.spo2_percent`, `${IN}monitor.heart_rate_per_min`, `${IN}monitor.airway_pressure_cmh2o`,
    `${OUT}demand.reference_mm`, `${IN}line_vacuum_mmhg`,
  ],
  timing: ["loop.late_s", "loop.computed_s", "loop.skipped", `${WATCH}bus.stale_ticks`, `${OUT}counters.late_share`],
};

const KEY = "opensuction-signals";

/** What was looked at last on this device, as far as it still is there. */
export function remembered(known) {
  try {
    const names = JSON.parse(sessionStorage.getItem(KEY)).filter((name) => known.has(name));
    if (names.length) return names;
  } catch {
    // Nothing is remembered, or something that is none.
  }
  return PRESETS.insertion;
}

export function remember(names) {
  try {
    sessionStorage.setItem(KEY, JSON.stringify(names));
  } catch {
    // Without storage it is chosen anew.
  }
}

/** The preset that these are; "own" where they are none. */
export function presetOf(names) {
  const same = ([, of]) => of.length === names.length && of.every((name) => names.includes(name));
  return (Object.entries(PRESETS).find(same) || ["own"])[0];
}
