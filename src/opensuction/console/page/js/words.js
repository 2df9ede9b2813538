// Numbers and times as people read them.

/** A number in some decimals; no minus before a zero. */
export function number(value, decimals = 0) {
  const words = value.toFixed(decimals);
  return Number(words) === 0 ? words.replace("-", "") : words.replace("-", "\u2212");
}

/** A time that runs down: 1:05, or 2 h 10 min where it is long. Never shows 0:00 before it is. */
export function countdown(seconds) {
  const whole = Math.max(Math.ceil(seconds), 0);
  if (whole < 3600) return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
  return `${Math.floor(whole / 3600)} h ${String(Math.floor((whole % 3600) / 60)).padStart(2, "0")} min`;
}

/** How old something is: 3 s, 4 min, 2 h. */
export function age(seconds) {
  if (seconds < 120) return `${Math.floor(seconds)} s`;
  if (seconds < 7200) return `${Math.floor(seconds / 60)} min`; // 119 min, then 2 h
  return `${Math.floor(seconds / 3600)} h`;
}

/** The time of day of an instant. */
export function clock(instant, withSeconds = false) {
  return new Date(instant).toLocaleTimeString([], {
    hour: "2-digit",
    minute: "2-digit",
    second: withSeconds ? "2-digit" : undefined,
    hour12: false,
  });
}

/** Date and time of an instant. */
export function day(instant) {
  return new Date(instant).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });
}

/** A word with a capital letter. */
export function capital(words) {
  return words.slice(0, 1).toUpperCase() + words.slice(1);
}
