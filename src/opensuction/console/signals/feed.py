"""Signals of one machine to all who look: the ring is read once, each set of channels encoded once.

It works only while somebody looks. Everything here runs on the event loop and never waits: what a
turn does is some arrays, and a message for each client that is handed over, not sent.

A subscriber to signals: its queue of messages to be sent, never more than a few.

A client that takes them too slowly loses some, and is told how many rows. It is never waited for,
and what waits for it never grows.
"""

import asyncio
import contextlib
import json
import time
from collections import deque
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from opensuction.console.signals.channel import Block, Channel, Picker, with_missed
from opensuction.console.signals.source import (
    Found,
    Occurrence,
    PastRows,
    SignalSource,
    SourceFacts,
)

WAITING_MOST = 24
"""Messages; of frames more than half a second."""
STALLED_S = 10.0
"""Who takes nothing for so long is let go."""


class Subscriber:
    """Queue of messages for one client, in the order in which they came."""

    def __init__(self, channels: tuple[Channel, ...]) -> None:
        self.channels = channels
        self._waiting: deque[bytes | str] = deque()
        self._here = asyncio.Event()
        self._rows_lost = self._texts_lost = 0
        self._stalled_since_s: float | None = None

    def put_rows(self, message: bytes, rows: int, missed: int) -> None:
        """A frame of so many rows, which already tells of missed ones."""
        if len(self._waiting) >= WAITING_MOST:
            self._rows_lost += rows + missed
            return
        if self._rows_lost:
            message, self._rows_lost = with_missed(message, self._rows_lost), 0
        self._put(message)

    def put_text(self, message: str) -> None:
        """Something that happened."""
        if len(self._waiting) >= WAITING_MOST:
            self._texts_lost += 1
            return
        self._put(message)

    def _put(self, message: bytes | str) -> None:
        self._waiting.append(message)
        self._here.set()

    async def take(self) -> bytes | str:
        """The next one to be sent; waits for it."""
        while not self._waiting:
            if self._texts_lost:
                lost, self._texts_lost = self._texts_lost, 0
                return say("lost", messages=lost)
            self._here.clear()
            await self._here.wait()
        return self._waiting.popleft()

    def is_stalled(self, now_s: float) -> bool:
        """True once its client has taken nothing for too long."""
        if len(self._waiting) < WAITING_MOST:
            self._stalled_since_s = None
            return False
        if self._stalled_since_s is None:
            self._stalled_since_s = now_s
        return now_s - self._stalled_since_s > STALLED_S


def say(kind: str, **fields: Any) -> str:
    """A message in words."""
    return json.dumps({"kind": kind, **fields}, allow_nan=False, separators=(",", ":"))


FRAMES_PER_S = 40.0
"""Above the 30 that a page shall draw."""
SUBSCRIBERS_MOST = 48
PICKERS_KEPT = 64
PAST_MOST_S = 9.0
"""Of the ring's ten: the rest is overwritten while it is read."""


class FullError(Exception):
    """As many look already as may."""


class Feed:
    """Of one machine's folder."""

    def __init__(self, folder: Path) -> None:
        self._source = SignalSource(folder)
        self._subscribers: set[Subscriber] = set()
        self._pickers: dict[tuple[Channel, ...], Picker] = {}
        self._task: asyncio.Task[None] | None = None
        self.stalled: set[Subscriber] = set()
        """Those that are let go, for they take nothing."""

    @contextlib.asynccontextmanager
    async def subscribed(
        self, channels: tuple[Channel, ...], past_s: float
    ) -> AsyncIterator[Subscriber]:
        """Rows of some channels from now on, and first of so much time before.

        Raises FullError where too many look already.
        """
        if len(self._subscribers) >= SUBSCRIBERS_MOST:
            raise FullError
        if not self.is_working:
            self._source.skip()
        one = Subscriber(channels)
        if self._source.facts is not None:
            one.put_text(_words_of(self._source.facts))
        past = self._past(past_s)
        if past is None:
            self._subscribers.add(one)
        self._begin()
        catching_up = None if past is None else asyncio.create_task(self._catch_up(one, past))
        try:
            yield one
        finally:
            if catching_up is not None:
                catching_up.cancel()
            self._subscribers.discard(one)
            self.stalled.discard(one)

    @property
    def is_working(self) -> bool:
        """True while it reads the ring."""
        return self._task is not None and not self._task.done()

    def _past(self, past_s: float) -> PastRows | None:
        facts = self._source.facts
        if facts is None or past_s <= 0.0:
            return None
        rows = round(min(past_s, PAST_MOST_S) / facts.period_s)
        return self._source.before(self._source.next - rows)

    async def _catch_up(self, one: Subscriber, past: PastRows) -> None:
        """Give a client what has been, a piece a frame, until it has come to where all are."""
        begun_with = self._source.facts
        while (found := past.read()) is not None:
            self._give(found, {one})
            if past.is_over:
                break
            await asyncio.sleep(1.0 / FRAMES_PER_S)
        # Since the last look nothing else has run: no row is left out or comes twice.
        if self._source.facts is not None and self._source.facts is not begun_with:
            one.put_text(_words_of(self._source.facts))
        self._subscribers.add(one)
        self._begin()

    def _begin(self) -> None:
        if not self.is_working:
            self._task = asyncio.create_task(self._run())

    async def _run(self) -> None:
        """A turn a frame, as long as somebody looks."""
        idle, due_s = 0, time.monotonic()
        while True:
            idle = 0 if self._subscribers else idle + 1
            if idle > FRAMES_PER_S:
                return  # in the same step: whoever came while it slept would get no row, ever
            self._give(self._source.read(), self._subscribers)
            now_s = time.monotonic()
            self.stalled.update(one for one in self._subscribers if one.is_stalled(now_s))
            due_s = max(due_s + 1.0 / FRAMES_PER_S, now_s)
            await asyncio.sleep(due_s - now_s)

    def _give(self, found: Found, to: set[Subscriber]) -> None:
        """Hand what has come to some clients."""
        if not to:
            return
        old = [one for one in found.blocks if _is_before(found.facts, one.source)]
        for block in old:
            self._give_block(block, to)
        if found.facts is not None:
            _tell(_words_of(found.facts), to)
        for block in found.blocks[len(old) :]:
            self._give_block(block, to)
        for happened in found.occurrences:
            _tell(_words_of_occurrence(happened), to)

    def _give_block(self, block: Block, to: set[Subscriber]) -> None:
        messages: dict[tuple[Channel, ...], bytes] = {}
        for one in to:
            message = messages.get(one.channels)
            if message is None:
                message = messages[one.channels] = self._picker(one.channels).encode(block)
            one.put_rows(message, len(block.rows), block.missed)

    def _picker(self, channels: tuple[Channel, ...]) -> Picker:
        found = self._pickers.get(channels)
        if found is None:
            if len(self._pickers) >= PICKERS_KEPT:
                self._pickers.clear()
            found = self._pickers[channels] = Picker(channels)
        return found


def _is_before(facts: SourceFacts | None, source: int) -> bool:
    return facts is not None and source < facts.source


def _tell(message: str, to: set[Subscriber]) -> None:
    for one in to:
        one.put_text(message)


def _words_of(facts: SourceFacts) -> str:
    return say("source", **facts._asdict())


def _words_of_occurrence(happened: Occurrence) -> str:
    fields = happened._asdict()
    return say("event", what=fields.pop("kind"), **fields)
