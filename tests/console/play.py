"""Runs what waits, in a thread of its own: a browser's driver leaves its own loop in this one."""

import asyncio
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

T = TypeVar("T")


def play(coroutine: Coroutine[Any, Any, T], seconds: float) -> T:
    """What it returns; raises TimeoutError where that takes longer."""

    async def timed() -> T:
        return await asyncio.wait_for(coroutine, seconds)

    with ThreadPoolExecutor(1) as thread:
        return thread.submit(lambda: asyncio.run(timed())).result()
