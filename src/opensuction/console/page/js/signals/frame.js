// A message of the stream, read: the layout is that of console/signals/channel.py.

const MAGIC = 0x5347;
const VERSION = 1;

/** What a binary message holds; null for one of another kind. Nothing is copied. */
export function readFrame(data) {
  const view = new DataView(data);
  if (data.byteLength < 48 || view.getUint16(0, true) !== MAGIC || view.getUint16(2, true) !== VERSION) return null;
  const size = view.getUint16(4, true);
  const channels = view.getUint16(6, true);
  const rows = view.getUint32(8, true);
  if (data.byteLength !== size + 4 * rows * (1 + channels)) return null;
  const values = [];
  for (let i = 0; i < channels; i += 1) {
    values.push(new Float32Array(data, size + 4 * rows * (1 + i), rows));
  }
  return {
    rows,
    missed: view.getUint32(12, true),
    source: view.getUint32(16, true),
    tick: view.getFloat64(24, true),
    time_s: view.getFloat64(32, true),
    period_s: view.getFloat64(40, true),
    steps: new Uint32Array(data, size, rows),
    values,
  };
}
