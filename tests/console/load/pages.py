"""Pages without a browser: sockets that take what a page takes, in a process of their own.

``python -m tests.console.load.pages URL COOKIE LIVE SIGNALS CHANNELS``: says a line once something
has come to each, goes on until its input is closed, and says what came, as JSON.
CHANNELS: what each socket of signals watches.
"""

import asyncio
import json
import sys
import threading
from contextlib import suppress
from typing import NamedTuple

from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from opensuction.console.signals.channel import decode


class Came(NamedTuple):
    """What came to all of them."""

    states: int
    frames: int
    rows: int
    missed: int
    """Rows that were told to be missing."""
    gaps: int
    """Rows that were missing without a word."""


class Tally:
    """Of one page."""

    def __init__(self) -> None:
        self.states = self.frames = self.rows = self.missed = self.gaps = 0
        self._next: float | None = None
        self._source = 0
        self.heard = asyncio.Event()

    def take(self, message: bytes) -> None:
        """Ticks follow one another, but for those that were told."""
        frame = decode(message)
        count = len(frame.times_s)
        if self._next is not None and frame.source == self._source:
            self.gaps += int(frame.first_tick - self._next) - frame.missed
        self._source, self._next = frame.source, frame.first_tick + count
        self.frames, self.rows = self.frames + 1, self.rows + count
        self.missed += frame.missed


async def _look(url: str, cookie: str, tally: Tally) -> None:
    headers = {
        "Cookie": cookie,
        "Origin": url.split("/api/", maxsplit=1)[0].replace("ws:", "http:"),
    }
    with suppress(ConnectionClosed):
        async with connect(url, additional_headers=headers, compression=None) as socket:
            async for message in socket:
                if isinstance(message, bytes):
                    tally.take(message)
                elif "/live" in url:
                    tally.states += 1
                if tally.states or tally.frames:
                    tally.heard.set()


async def _look_all(
    url: str, cookie: str, live: int, channels: list[str], over: asyncio.Event
) -> Came:
    """So many live sockets, and one of signals for each set of channels, until it is over."""
    base = url.replace("http", "ws", 1) + "/api/v1"
    urls = [f"{base}/live"] * live + [f"{base}/signals?channels={one}" for one in channels]
    tallies = [Tally() for _ in urls]
    pairs = zip(urls, tallies, strict=True)
    works = [asyncio.create_task(_look(one, cookie, tally)) for one, tally in pairs]
    await asyncio.gather(*(tally.heard.wait() for tally in tallies))
    sys.stdout.write("all have heard something\n")
    sys.stdout.flush()
    await over.wait()
    for work in works:
        work.cancel()
    await asyncio.gather(*works, return_exceptions=True)
    names = Came._fields
    return Came(*(sum(getattr(one, name) for one in tallies) for name in names))


async def _main(url: str, cookie: str, live: int, signals: int, channels: str) -> None:
    over = asyncio.Event()
    loop = asyncio.get_running_loop()

    def wait() -> None:
        sys.stdin.read()
        loop.call_soon_threadsafe(over.set)

    threading.Thread(target=wait, daemon=True).start()
    came = await _look_all(url, cookie, live, [channels] * signals, over)
    sys.stdout.write(json.dumps(came._asdict()))


if __name__ == "__main__":
    _, address, shown, live_count, signal_count, names = sys.argv
    asyncio.run(_main(address, shown, int(live_count), int(signal_count), names))
