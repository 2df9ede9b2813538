// The order of what a person presses: each change is sent once the former one was answered or has
// failed, for two requests may travel on two connections. STOP goes beside it, and drops what waits:
// a start must not follow the stop that was pressed after it.

const WAIT_MS = 5000; // as the console's own limit: what was pressed longer ago may mean another machine

/** Why something was not sent. */
export const LATE = "late";
export const STOPPED = "stopped";

export class Order {
  constructor() {
    this.last = Promise.resolve();
    this.waiting = new Set();
  }

  /** Do something in its turn; refuse(LATE | STOPPED) gives the error where that never comes. */
  async take(act, refuse) {
    const former = this.last;
    let leave;
    const mine = new Promise((done) => { leave = done; });
    this.last = former.then(() => mine); // who gives up lets nobody pass those before
    try {
      await this.wait(former, refuse);
      return await act();
    } finally {
      leave();
    }
  }

  wait(former, refuse) {
    return new Promise((go, fail) => {
      const end = () => {
        clearTimeout(timer);
        this.waiting.delete(drop);
      };
      const drop = (why) => {
        end();
        fail(refuse(why));
      };
      const timer = setTimeout(() => drop(LATE), WAIT_MS);
      this.waiting.add(drop);
      former.then(() => {
        end();
        go();
      });
    });
  }

  /** STOP was pressed: nothing is sent that waits now. */
  stop() {
    for (const drop of [...this.waiting]) drop(STOPPED);
  }
}
