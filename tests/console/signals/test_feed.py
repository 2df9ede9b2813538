"""All who look get the same rows, from a ring that is read once; whoever is slow loses some."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest

from opensuction.console.signals import feed as feeds
from opensuction.console.signals.channel import CHANNELS, Frame, decode
from opensuction.console.signals.feed import (
    SUBSCRIBERS_MOST,
    WAITING_MOST,
    Feed,
    FullError,
    Subscriber,
)
from tests.console.play import play
from tests.console.written_machine import WrittenMachine

pytestmark = pytest.mark.real_time

HEAD = (CHANNELS["inputs.readings.head_mm"],)
TIP = (CHANNELS["tip.high_mm"], CHANNELS["outputs.phase"])
SECONDS = 20.0


async def frames(one: Subscriber, rows: int) -> tuple[list[Frame], list[dict[str, Any]]]:
    """What comes until there are so many rows, and the words between."""
    found: list[Frame] = []
    words = []
    while sum(len(frame.times_s) for frame in found) < rows:
        message = await one.take()
        if isinstance(message, bytes):
            found.append(decode(message))
        else:
            words.append(json.loads(message))
    return found, words


def ticks(found: list[Frame]) -> list[int]:
    return [int(one.first_tick) + i for one in found for i in range(len(one.times_s))]


def test_rows_follow_one_another_from_the_past_to_now(tmp_path: Path) -> None:
    async def look() -> None:
        with WrittenMachine(tmp_path, "") as machine:
            for _ in range(800):
                machine.tick()
            feed, newest = Feed(tmp_path), machine.number
            async with feed.subscribed(HEAD, 0.5) as one, feed.subscribed(TIP, 0.0) as other:
                found, words = await frames(one, 560)
                seen = ticks(found)
                assert seen == list(range(seen[0], seen[0] + len(seen)))
                last = machine.number  # it writes on while somebody comes
                assert newest - 505 <= seen[0] <= last - 495
                assert words[0]["kind"] == "source"
                assert words[1]["name"] == "parked"
                late, _ = await frames(other, 20)
                assert ticks(late)[0] > seen[0] + 400
                assert {len(frame.values) for frame in late} == {2}

    play(look(), SECONDS)


def test_who_takes_nothing_loses_rows_and_nobody_else_does(tmp_path: Path) -> None:
    async def look() -> None:
        with WrittenMachine(tmp_path, ""):
            feed = Feed(tmp_path)
            async with feed.subscribed(HEAD, 0.0) as slow, feed.subscribed(HEAD, 0.0) as good:
                quick, _ = await frames(good, 260)
                assert sum(one.missed for one in quick) == 0
                late, _ = await frames(slow, 260)
                lost = [i for i, one in enumerate(late) if one.missed]
                assert lost
                assert WAITING_MOST - 3 <= lost[0] <= WAITING_MOST
                before, after = late[lost[0] - 1], late[lost[0]]
                gap = after.first_tick - before.first_tick - len(before.times_s)
                assert gap == after.missed > 0

    play(look(), SECONDS)


def test_who_is_stalled_is_let_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("opensuction.console.signals.feed.STALLED_S", 0.0)

    async def look() -> None:
        with WrittenMachine(tmp_path, ""):
            feed = Feed(tmp_path)
            async with feed.subscribed(HEAD, 0.0) as slow:
                while slow not in feed.stalled:
                    await asyncio.sleep(0.01)
            assert slow not in feed.stalled

    play(look(), SECONDS)


def test_only_so_many_may_look(tmp_path: Path) -> None:
    async def look() -> None:
        feed = Feed(tmp_path)
        looking = [feed.subscribed(HEAD, 0.0) for _ in range(SUBSCRIBERS_MOST + 1)]
        for one in looking[:-1]:
            await one.__aenter__()
        with pytest.raises(FullError):
            await looking[-1].__aenter__()
        await looking[0].__aexit__(None, None, None)
        async with feed.subscribed(HEAD, 0.0):
            pass
        for one in looking[1:-1]:
            await one.__aexit__(None, None, None)

    play(look(), SECONDS)


def test_nothing_is_done_while_nobody_looks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(feeds, "FRAMES_PER_S", 200.0)

    async def look() -> None:
        with WrittenMachine(tmp_path, ""):
            feed = Feed(tmp_path)
            async with feed.subscribed(HEAD, 0.0) as one:
                await frames(one, 5)
            while feed.is_working:
                await asyncio.sleep(0.01)
            async with feed.subscribed(HEAD, 0.0) as one:
                await frames(one, 5)

    play(look(), SECONDS)


def test_whoever_comes_as_it_comes_to_rest_gets_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Turns of half a second, two of them idle: the instants lie on both sides of each turn.
    monkeypatch.setattr(feeds, "FRAMES_PER_S", 2.0)

    async def come_back(pause_s: float, past_s: float) -> None:
        feed = Feed(tmp_path)
        async with feed.subscribed(HEAD, 0.0) as one:
            await frames(one, 1)
        await asyncio.sleep(pause_s)
        async with feed.subscribed(HEAD, past_s) as one:
            await asyncio.wait_for(frames(one, 600), 10.0)

    async def look() -> None:
        with WrittenMachine(tmp_path, ""):
            pauses = [(0.1 * i, past_s) for i in range(21) for past_s in (0.0, 0.5)]
            await asyncio.gather(*(come_back(*one) for one in pauses))

    play(look(), SECONDS)


def test_a_control_process_that_is_replaced_is_told_and_followed(tmp_path: Path) -> None:
    async def look() -> None:
        feed = Feed(tmp_path)
        with WrittenMachine(tmp_path, ""):
            async with feed.subscribed(HEAD, 0.0) as one:
                first, words = await frames(one, 20)
                assert {frame.source for frame in first} == {1}
                last = first[-1]
        # The stream is begun anew here: its client went on while the machine was replaced.
        async with feed.subscribed(HEAD, 0.0) as one:
            with WrittenMachine(tmp_path, "", run="20261123T130000-another"):
                words = []
                while not any(word.get("run") == "20261123T130000-another" for word in words):
                    _, more = await frames(one, 1)
                    words += more
                after, _ = await frames(one, 20)
                assert {frame.source for frame in after} == {2}
                assert after[0].times_s[0] > last.times_s[-1]
                assert after[0].first_tick < last.first_tick + 1000

    play(look(), SECONDS)
