"""The state, `RATE_HZ` times a second, to every page that listens: worked out once for all.

A page that cannot follow misses states, and gets the newest when it can: nothing is queued for it.
"""

import asyncio

from opensuction.console.live.hub import Hub

RATE_HZ = 20.0


class Broadcast:
    """Runs as long as anybody listens; within one event loop."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._next: asyncio.Future[str] | None = None
        self._task: asyncio.Task[None] | None = None
        self._listeners = 0

    def join(self) -> None:
        """One more listens."""
        self._listeners += 1
        if self._task is None or self._task.done():
            self._task = asyncio.get_running_loop().create_task(self._run())

    def leave(self) -> None:
        """One less."""
        self._listeners -= 1

    async def next(self) -> str:
        """The next state, as text."""
        if self._next is None or self._next.done():
            self._next = asyncio.get_running_loop().create_future()
        return await asyncio.shield(self._next)

    async def _run(self) -> None:
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        while self._listeners > 0:
            waiting = self._next
            if waiting is not None and not waiting.done():
                waiting.set_result(self._hub.now().text)
            due_s = max(due_s + 1.0 / RATE_HZ, loop.time())
            await asyncio.sleep(due_s - loop.time())
