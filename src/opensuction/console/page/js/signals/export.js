// What is seen, as a table: every row of it, not only the points that were drawn.

import { text } from "../text.js";

const ROWS_A_PIECE = 2000;

/** CSV of some channels between two instants, in pieces. about: lines that say what it is. */
export function csv(buffer, names, [from_s, to_s], utc_offset_s, about) {
  const places = names.map((name) => buffer.channels.findIndex((one) => one.name === name));
  const titles = places.map((place) => {
    const { name, unit } = buffer.channels[place];
    return unit ? `${name} [${unit}]` : name;
  });
  const pieces = [...about.map((line) => `# ${line.replace(/[\r\n]+/g, " ")}\n`), ["utc", "time_s [s]", "tick", ...titles].join(",") + "\n"];
  const end = buffer.find(to_s + 1e-9);
  let lines = [];
  for (let row = buffer.find(from_s); row < end; row += 1) {
    const time_s = buffer.time_s[row & buffer.mask];
    const utc = new Date((time_s + utc_offset_s) * 1000).toISOString();
    const values = places.map((place) => {
      const value = buffer.value(place, row);
      return Number.isFinite(value) ? String(Number(value.toPrecision(7))) : "";
    });
    lines.push([utc, time_s.toFixed(6), buffer.tick[row & buffer.mask], ...values].join(","));
    if (lines.length === ROWS_A_PIECE) {
      pieces.push(lines.join("\n") + "\n");
      lines = [];
    }
  }
  if (lines.length) pieces.push(lines.join("\n") + "\n");
  return pieces;
}

/** Have the browser keep it as a file. */
export function save(pieces, name) {
  const url = URL.createObjectURL(new Blob(pieces, { type: "text/csv;charset=utf-8" }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

/** What a table says of itself. */
export function aboutOf(context, facts, buffer, names) {
  const words = text.signals.file;
  const titles = names.map((name) => buffer.channels.find((one) => one.name === name));
  return [
    words.title,
    context.machine?.is_twin === false ? text.shell.noticePlain : text.shell.notice,
    `${words.machine}: ${context.machine?.serial ?? "?"}; ${words.run}: ${facts?.run ?? "?"}; ${words.version}: ${facts?.version ?? "?"}; ${words.settings}: ${facts?.settings ?? "?"}`,
    `${words.period}: ${facts?.period_s ?? "?"} s; ${words.missed}: ${buffer.missed}; ${words.empty}`,
    words.clock,
    ...titles.map(({ name, title, origin, unit }) => `${name}: ${title} (${origin}${unit ? `, ${unit}` : ""})`),
  ];
}
