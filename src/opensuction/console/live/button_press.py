"""A button pressed by a person at a page: sent to the control loop, and what became of it.

The answer is found among the loop's events. What is asked again under the same key is the same
question: it is not sent again, and gets the same answer. To stop is sent each time.
"""

import asyncio
import time
from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from opensuction.console.guard.problem import Problem
from opensuction.console.live.hub import Hub
from opensuction.console.live.row import Row
from opensuction.console.live.state import refused
from opensuction.ipc.mailbox import PATIENCE_S
from opensuction.ipc.ring import COLUMNS, EventReader, FollowedRing, ProcessEvent
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import STOP
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.runtime import launch
from opensuction.runtime.launch import CONTROLLER_REQUEST_LOOKS_S, PRESSED
from opensuction.runtime.machine_button import BUTTONS
from opensuction.runtime.machine_folder import EVENTS

ANSWERS_S = 0.5
"""Within this time an answer is there: five hundred ticks."""
WRITTEN_S = 0.05
"""Within this time after an answer its row is there."""
KEYS_KEPT = 1024
REFUSABLE = frozenset(button.field for button in BUTTONS if button.is_refusable)


class ButtonPress(NamedTuple):
    """Request of a person."""

    ask: str
    """A field of `kernel.interface.Requests`."""
    who: str
    key: str


class Answered(NamedTuple):
    """Answer to a button press."""

    verdict: str
    """See `ipc.mailbox.Answer`."""
    refusal: dict[str, str] | None
    """Why the core refused it, though the button went down."""
    phase: str
    took_ms: float
    """From here until the answer was found."""


class Asking:
    """Of one machine; within one event loop."""

    def __init__(self, folder: Path, hub: Hub) -> None:
        self._folder, self._hub = folder, hub
        self._events = FollowedRing(folder / EVENTS, lambda columns: columns == COLUMNS)
        self._reader: EventReader | None = None
        self._waiting: dict[str, asyncio.Future[ProcessEvent]] = {}
        self._listening: asyncio.Task[None] | None = None
        self._asked: OrderedDict[str, tuple[ButtonPress, asyncio.Future[Answered]]] = OrderedDict()
        # To stop has a thread of its own: nothing else that is sent can be in its way.
        self._threads = {is_stop: ThreadPoolExecutor(1, "ask") for is_stop in (True, False)}

    def close(self) -> None:
        """Ask no more."""
        for one in self._threads.values():
            one.shutdown(wait=False, cancel_futures=True)

    async def ask(self, asked: ButtonPress) -> Answered:
        """Press a button. Raises Problem where nobody answers, or the key is another question's.

        To stop needs a key that no other request has had: its answer is found by it.
        """
        if asked.ask == STOP:  # never answered from memory: the tip may be elsewhere by now
            return await asyncio.shield(asyncio.create_task(self._carry_out(asked)))
        known = self._asked.get(asked.key)
        if known is not None:
            if known[0] != asked:
                raise Problem(409, "this key is that of another request")
            return await asyncio.shield(known[1])
        answer = asyncio.get_running_loop().create_task(self._carry_out(asked))
        answer.add_done_callback(lambda done: self._forget(asked.key, done))
        self._asked[asked.key] = (asked, answer)
        while len(self._asked) > KEYS_KEPT:
            self._asked.popitem(last=False)
        return await asyncio.shield(answer)

    def _forget(self, key: str, done: asyncio.Future[Answered]) -> None:
        """Allow a request that was not answered to be made again."""
        if done.cancelled() or done.exception() is not None:
            self._asked.pop(key, None)

    async def _carry_out(self, asked: ButtonPress) -> Answered:
        loop = asyncio.get_running_loop()
        begun_s = loop.time()
        found: asyncio.Future[ProcessEvent] = loop.create_future()
        self._listen(asked.key, found)
        try:
            await self._send(asked)
            event = await asyncio.wait_for(found, ANSWERS_S)
        except TimeoutError:
            raise Problem(503, _unheard(asked, "the controller does not answer")) from None
        except InputError as error:
            raise Problem(503, _unheard(asked, str(error))) from None
        finally:
            self._waiting.pop(asked.key, None)
        took_ms = 1e3 * (loop.time() - begun_s)
        row = await self._row_after(int(event.fields["tick"]))
        verdict = str(event.fields["verdict"])
        is_refused = row is not None and verdict == PRESSED and asked.ask in REFUSABLE
        return Answered(
            verdict=verdict,
            refusal=refused(row) if row is not None and is_refused else None,
            phase="unknown" if row is None else name_of(Phase(row.whole("outputs.phase"))),
            took_ms=round(took_ms, 2),
        )

    async def _send(self, asked: ButtonPress) -> None:
        """At once where there is room; where there is none a thread waits for it, not the pages.

        A busy computer may take long to come round to another thread: the usual way has none.
        """
        try:
            self._put(asked, 0.0)
        except InputError:
            loop = asyncio.get_running_loop()
            await loop.run_in_executor(
                self._threads[asked.ask == STOP], self._put, asked, PATIENCE_S
            )

    def _put(self, asked: ButtonPress, patience_s: float) -> None:
        launch.send(self._folder, asked.ask, asked.who, asked.key, patience_s)

    async def _row_after(self, tick: int) -> Row | None:
        """The row of that tick, or a later one; None where the controller has ended meanwhile."""
        ends_s = time.monotonic() + WRITTEN_S
        while time.monotonic() < ends_s:
            newest = self._hub.newest()
            if newest is not None and (row := Row(newest[1])).whole("inputs.tick") >= tick:
                return row
            await asyncio.sleep(CONTROLLER_REQUEST_LOOKS_S)
        return None

    def _listen(self, key: str, found: asyncio.Future[ProcessEvent]) -> None:
        if not self._waiting:
            self._open()
            if self._reader is not None and self._events.reader is not None:
                # What was told before nobody waits for.
                self._reader.go_on_after(self._events.reader.newest())
        self._waiting[key] = found
        if self._listening is None or self._listening.done():
            self._listening = asyncio.get_running_loop().create_task(self._hear())

    def _open(self) -> None:
        if self._events.look() and self._events.reader is not None:
            self._reader = EventReader(self._events.reader)

    async def _hear(self) -> None:
        """Read events as long as anybody waits for one."""
        while self._waiting:
            self._open()
            for event in [] if self._reader is None else self._reader.read()[0]:
                found = self._waiting.get(str(event.fields.get("key")))
                if found is not None and not found.done():
                    found.set_result(event)
            await asyncio.sleep(CONTROLLER_REQUEST_LOOKS_S)


def _unheard(asked: ButtonPress, reason: str) -> str:
    if asked.ask == STOP:
        return f"NOBODY HEARS THE STOP ({reason}): draw the catheter out by the handle"
    return reason
