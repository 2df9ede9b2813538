// Pointers on a button that acts as a finger comes down: the click that their lift makes says nothing
// new, and any other click is that of a key, a screen reader or a switch, which must not be lost.

const CLICK_MS = 500; // within this time a lift makes its click

export class Pointers {
  constructor(button) {
    this.held = new Set();
    this.lifted_ms = -Infinity;
    button.addEventListener("pointerdown", (event) => this.held.add(event.pointerId));
    // Wherever it is lifted: one that slid off makes no click on the button.
    addEventListener("pointerup", (event) => this.lift(event), { capture: true });
    addEventListener("pointercancel", (event) => this.held.delete(event.pointerId), { capture: true });
  }

  lift(event) {
    if (this.held.delete(event.pointerId)) this.lifted_ms = performance.now();
  }

  /** Whether a click of the button only ends what a pointer began there. */
  end(click) {
    const own = click.detail > 0 && performance.now() - this.lifted_ms < CLICK_MS;
    this.lifted_ms = -Infinity;
    return own;
  }
}
