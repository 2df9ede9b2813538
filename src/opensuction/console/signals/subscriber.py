"""A subscriber to signals: its queue of messages to be sent, never more than a few.

A client that takes them too slowly loses some, and is told how many rows. It is never waited for,
and what waits for it never grows.
"""

import asyncio
import json
from collections import deque
from typing import Any

from opensuction.console.signals.channel import Channel
from opensuction.console.signals.frame import with_missed

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
