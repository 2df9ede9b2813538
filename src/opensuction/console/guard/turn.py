"""The order of one person's changes: each is carried out in its turn, that of its headers' arrival.

A request is carried out by threads and beside others, so of two buttons pressed one after the other
the second could reach the machine first. Here each request of a session that changes something has
a place in the session's queue from its headers until its answer is complete; a queue that is empty
is forgotten. Sessions do not wait for each other, and who shows none has no queue.

To stop waits for nothing. What anybody pressed before it and what still waits then, for its turn or
for the right to a button, is refused: a start must not follow the stop that was pressed after it.
"""

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

from starlette.types import Receive

from opensuction.console.guard.limits import Limits
from opensuction.console.guard.problem import Problem

STOPPED = "Stop was pressed after this, so it was not carried out: press again what is still wanted"
BUSY = "what was pressed before is still being carried out: press again once that is answered"
GONE = "whoever pressed this has gone before its turn, so it was not carried out"


class Turn:
    """The place of one request; within one event loop."""

    def __init__(self, turns: "Turns", number: int, queue: "list[Turn]") -> None:
        self._turns, self.number, self._queue = turns, number, queue
        self._called = asyncio.Event()
        self._refused: Problem | None = None
        self._has_begun = False
        late = Problem(408, f"the body did not come within {turns.place_s:g} s: press again")
        self._timer = asyncio.get_running_loop().call_later(turns.place_s, self.refuse, late)

    def arrive(self) -> None:
        """Its body has come, in time to keep the place."""
        self._timer.cancel()

    def leave(self) -> None:
        """Give the place back: whoever is next goes on. May be called again."""
        self._timer.cancel()
        if self in self._queue:
            self._queue.remove(self)
        if self._queue:
            self._queue[0]._called.set()

    def refuse(self, why: Problem) -> None:
        """Have it refused as it waits, or as it `check`s; the first reason holds.

        What is carried out already keeps the place: nothing else of its session may begin.
        """
        self._refused = self._refused or why
        self._called.set()
        if not self._has_begun:
            self.leave()

    def check(self) -> None:
        """Raises the Problem by which it was refused."""
        if self._refused is not None:
            raise self._refused

    async def wait(self, receive: Receive) -> None:
        """Wait until the request may be carried out.

        receive: of the request, its body taken: says when whoever asked has gone.
        Raises Problem where it must not be carried out any more.
        """
        if self._refused is None and self._queue[0] is not self:
            await self._wait(receive)
        self.check()
        self._has_begun = True

    async def _wait(self, receive: Receive) -> None:
        called = asyncio.ensure_future(self._called.wait())
        gone = asyncio.ensure_future(_hear_end(receive))
        ends_s = self._turns.wait_s
        try:
            await asyncio.wait({called, gone}, timeout=ends_s, return_when=asyncio.FIRST_COMPLETED)
        finally:
            called.cancel()
            gone.cancel()
        if gone.done():
            self.refuse(Problem(409, GONE))
        elif not self._called.is_set():
            self.refuse(Problem(503, BUSY))

    def stop(self) -> None:
        """It is to stop: it waits for nobody, and what came before it is refused."""
        self._turns.refuse_before(self.number)
        self.leave()


async def _hear_end(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass


class Turns:
    """The queues of one console."""

    def __init__(self, limits: Limits) -> None:
        self.place_s, self.wait_s = limits.place_s, limits.turn_s
        self._queues: dict[str | int, list[Turn]] = {}
        self._numbers = count()

    @contextmanager
    def take(self, session: str | None) -> Iterator[Turn]:
        """The last place of a session's queue, given back in every case; None: of one of its own.

        It is lost where `Turn.arrive` is not called in time: a body that does not come holds nobody
        up for long.
        """
        number = next(self._numbers)
        name = number if session is None else session
        queue = self._queues.setdefault(name, [])
        turn = Turn(self, number, queue)
        queue.append(turn)
        try:
            yield turn
        finally:
            turn.leave()
            # One that left early ends when its queue may be another one already.
            if not queue and self._queues.get(name) is queue:
                del self._queues[name]

    def refuse_before(self, number: int) -> None:
        """Refuse what came before a stop and is not carried out yet."""
        turns = [turn for queue in self._queues.values() for turn in queue]
        for turn in turns:
            if turn.number < number:
                turn.refuse(Problem(409, STOPPED))
