// Fingers, mouse and keys on the plots.

const TAP_PX = 8;
const WHEEL = 0.0016;

/** act: {zoom(factor, x), pan(share), tap(x), nudge(pixels), toggle(), put(name), back()}; x in pixels of the
    element, share of the window's width. */
export function listen(element, act) {
  const down = new Map();
  let moved = 0;
  const placeOf = (event) => event.clientX - element.getBoundingClientRect().left;
  const spread = () => {
    const [one, other] = [...down.values()];
    return Math.max(Math.abs(one - other), 20);
  };
  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    element.setPointerCapture(event.pointerId);
    if (down.size === 0) moved = 0;
    down.set(event.pointerId, placeOf(event));
  });
  element.addEventListener("pointermove", (event) => {
    if (!down.has(event.pointerId)) return;
    const x = placeOf(event);
    const before = down.size === 2 ? spread() : 0;
    const by = x - down.get(event.pointerId);
    moved += Math.abs(by);
    down.set(event.pointerId, x);
    if (moved < TAP_PX) return;
    if (down.size === 2) {
      const [one, other] = [...down.values()];
      act.zoom(before / spread(), (one + other) / 2);
    } else act.pan(-by);
  });
  const up = (event) => {
    if (!down.delete(event.pointerId)) return;
    if (event.type === "pointerup" && moved < TAP_PX && down.size === 0) act.tap(placeOf(event));
  };
  element.addEventListener("pointerup", up);
  element.addEventListener("pointercancel", up);
  element.addEventListener("wheel", (event) => {
    if (event.ctrlKey) return;
    event.preventDefault();
    act.zoom(Math.exp(WHEEL * event.deltaY), placeOf(event));
  }, { passive: false });
  element.addEventListener("keydown", (event) => press(event, act));
}

function press(event, act) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  const zoom = { "+": 0.5, "=": 0.5, ArrowUp: 0.5, "-": 2, ArrowDown: 2 }[event.key];
  if (step && event.shiftKey) act.nudge(step);
  else if (step) act.pan(step * 80);
  else if (zoom) act.zoom(zoom, null);
  else if (event.key === " ") act.toggle();
  else if (event.key === "a" || event.key === "A") act.put("a");
  else if (event.key === "b" || event.key === "B") act.put("b");
  else if (event.key === "Escape") act.back();
  else return;
  event.preventDefault();
}
