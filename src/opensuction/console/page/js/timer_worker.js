// The worker of timer.js: tells when a time is over.

addEventListener("message", ({ data: { number, wait_ms } }) => {
  setTimeout(() => postMessage(number), wait_ms);
});
