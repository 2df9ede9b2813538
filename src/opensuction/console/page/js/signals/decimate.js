// Fewer points than rows, and no peak lost: of the rows of each pixel the least and the most.

/** Points of some channels between two instants: [times, values, values, ...], null where the line
    breaks. As many rows as two a pixel or fewer are given as they are. */
export function decimate(buffer, channels, from_s, to_s, pixels) {
  const begin = Math.max(buffer.find(from_s) - 1, buffer.first); // one beyond either end
  const end = Math.min(buffer.find(to_s) + 1, buffer.next);
  if (end - begin <= 2 * pixels) return each(buffer, channels, begin, end);
  return extremes(buffer, channels, [begin, end], (to_s - from_s) / pixels);
}

function each(buffer, channels, begin, end) {
  const { mask } = buffer;
  const times = [];
  const lines = channels.map(() => []);
  for (let row = begin; row < end; row += 1) {
    const at = row & mask;
    if (buffer.breaks[at] && times.length) {
      times.push((times[times.length - 1] + buffer.time_s[at]) / 2);
      for (const line of lines) line.push(null);
    }
    times.push(buffer.time_s[at]);
    channels.forEach((channel, i) => {
      const value = buffer.values[channel][at];
      lines[i].push(Number.isFinite(value) ? value : null);
    });
  }
  return [times, ...lines];
}

/* Pixels are counted from the clock's zero, not from the window's edge: the same rows stay together
   while the window moves, or peaks would flicker. */
function extremes(buffer, channels, [begin, end], pixel_s) {
  const { mask, time_s, breaks } = buffer;
  const times = [];
  const lines = channels.map(() => []);
  let row = begin;
  while (row < end) {
    const pixel = Math.floor(time_s[row & mask] / pixel_s);
    const ends_s = (pixel + 1) * pixel_s;
    const first = row;
    const isBroken = breaks[first & mask] && times.length > 0;
    row += 1;
    while (row < end && time_s[row & mask] < ends_s && !breaks[row & mask]) row += 1;
    const start_s = Math.max(time_s[first & mask], times.length ? times[times.length - 1] : -Infinity);
    const stop_s = time_s[(row - 1) & mask];
    if (isBroken) times.push(start_s);
    times.push(start_s, Math.max(start_s + (stop_s - start_s) / 2, start_s));
    for (let i = 0; i < channels.length; i += 1) {
      if (isBroken) lines[i].push(null);
      pushExtremes(lines[i], buffer.values[channels[i]], mask, first, row);
    }
  }
  return [times, ...lines];
}

function pushExtremes(line, values, mask, first, end) {
  let least = Infinity;
  let most = -Infinity;
  let leastAt = first;
  let mostAt = first;
  for (let row = first; row < end; row += 1) {
    const value = values[row & mask];
    if (value < least) { least = value; leastAt = row; }
    if (value > most) { most = value; mostAt = row; }
  }
  if (least === Infinity && most === -Infinity) line.push(null, null); // no valid value
  else if (leastAt <= mostAt) line.push(finite(least), finite(most));
  else line.push(finite(most), finite(least));
}

function finite(value) {
  return Number.isFinite(value) ? value : null;
}
