// Where an axis begins and ends, and what stands on it.

const LEAST_SPAN = { mm: 1, "mm/s": 5, mmHg: 10, cmH2O: 5, "%": 4, "1/min": 10, V: 1, A: 0.1, N: 0.05, rad: 0.2, s: 0.0005 };
const STEPS = [1, 2, 5, 10];

/** Limits of an axis that holds these values; they change in steps, so that the picture is calm. */
export function limitsOf(unit, least, most) {
  if (!(least <= most)) return [0, 1];
  if (unit === "" && least >= 0 && most <= 1) return [-0.1, 1.1];
  const span = Math.max(most - least, LEAST_SPAN[unit] ?? 1);
  const middle = (least + most) / 2;
  const step = stepOf(span / 5);
  const room = 0.04 * span;
  return [Math.floor((middle - span / 2 - room) / step) * step, Math.ceil((middle + span / 2 + room) / step) * step];
}

const TIMES_S = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60];

/** Instants where a line of the grid stands, at whole times of day, some pixels apart. */
export function instantsOf(from_s, to_s, pixels, offset_s) {
  const least_s = ((to_s - from_s) / pixels) * 95;
  const step_s = TIMES_S.find((one) => one >= least_s) ?? 120;
  const found = [];
  for (let i = Math.ceil((from_s + offset_s) / step_s); i * step_s <= to_s + offset_s; i += 1) found.push(i * step_s - offset_s);
  return found;
}

/** A round number not below this one. */
function stepOf(size) {
  const power = 10 ** Math.floor(Math.log10(size));
  return power * STEPS.find((one) => one * power >= size * 0.999);
}

/** Time of day of an instant of the machine's clock; as fine as the window is narrow. */
export function timeOfDay(instant_s, utc_offset_s, span_s) {
  const at = new Date((instant_s + utc_offset_s) * 1000);
  const two = (value) => String(value).padStart(2, "0");
  const whole = `${two(at.getHours())}:${two(at.getMinutes())}:${two(at.getSeconds())}`;
  if (span_s > 8) return whole;
  return `${whole}.${String(at.getMilliseconds()).padStart(3, "0").slice(0, span_s > 0.8 ? 1 : 3)}`;
}

/** A value with as many digits as its unit is worth. */
export function valueOf(value, unit) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return "∞";
  const decimals = { s: 6, mm: 2, N: 3, A: 3, rad: 3, V: 2, mmHg: 1, cmH2O: 1, "%": 1, "1/min": 0, "mm/s": 1 }[unit];
  if (decimals !== undefined) return value.toFixed(decimals).replace("-", "−");
  return String(Number(value.toPrecision(7))).replace("-", "−");
}
