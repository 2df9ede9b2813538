// Timers that go on in a hidden tab. There a browser lets the page's own act once a second, and once a
// minute after five minutes; a worker's it leaves alone. Whichever comes first acts: without a worker
// the page's own do. One that saves energy halts a hidden page with its workers, unless it holds a lock
// [Chrome-Freezing]: shared, so that each of several pages holds it.

navigator.locks?.request("watch", { mode: "shared" }, () => new Promise(() => {})).catch(() => {});

const waiting = new Map(); // number -> {fn, own}
const worker = begin();
let last = 0;

function begin() {
  try {
    const made = new Worker(new URL("timer_worker.js", import.meta.url));
    made.addEventListener("message", (event) => act(event.data));
    return made;
  } catch {
    return null;
  }
}

/** Call fn once after a while; gives what calls it off. */
export function after(wait_ms, fn) {
  last += 1;
  const number = last;
  waiting.set(number, { fn, own: setTimeout(() => act(number), wait_ms) });
  worker?.postMessage({ number, wait_ms });
  return () => drop(number);
}

/** Call fn again and again, for as long as the page is there. */
export function every(wait_ms, fn) {
  after(wait_ms, () => {
    every(wait_ms, fn);
    fn();
  });
}

function act(number) {
  const one = waiting.get(number);
  if (!one) return;
  drop(number);
  one.fn();
}

function drop(number) {
  clearTimeout(waiting.get(number)?.own);
  waiting.delete(number);
}
