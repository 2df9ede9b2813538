"""The queues of sessions: in order, bounded, and gone when empty."""

import asyncio
import contextlib

import pytest
from starlette.types import Message

from opensuction.console.guard.limits import UNHURRIED
from opensuction.console.guard.problem import Problem
from opensuction.console.guard.turn import Turns
from tests.console.play import play

LONG_S = 60.0
PATIENT = UNHURRIED._replace(place_s=60.0, turn_s=60.0)


async def stay() -> Message:
    """What a request hears whose sender stays."""
    await asyncio.Event().wait()
    raise AssertionError


async def have_begun(*waiting: "asyncio.Task[None]") -> list[bool]:
    """Which of them go on, once all have had the chance to."""
    for _ in range(10):
        await asyncio.sleep(0)
    return [one.done() for one in waiting]


def test_a_place_in_the_middle_that_is_given_up_lets_nobody_pass_the_first() -> None:
    async def test() -> None:
        turns = Turns(PATIENT)
        with turns.take("a") as first, turns.take("a") as second, turns.take("a") as third:
            await first.wait(stay)
            waiting = asyncio.ensure_future(third.wait(stay))
            second.leave()
            assert await have_begun(waiting) == [False]
            first.leave()
            assert await have_begun(waiting) == [True]

    play(test(), LONG_S)


def test_sessions_and_who_shows_none_do_not_wait_for_each_other() -> None:
    async def test() -> None:
        turns = Turns(PATIENT)
        with (
            turns.take("a"),
            turns.take("b") as other,
            turns.take(None) as one,
            turns.take(None) as another,
        ):
            for turn in (other, one, another):
                await turn.wait(stay)

    play(test(), LONG_S)


def test_a_queue_is_forgotten_once_it_is_empty() -> None:
    async def test() -> None:
        turns = Turns(PATIENT)
        for session in ("a", "b", None):
            with turns.take(session), turns.take(session) as second:
                second.leave()
        with contextlib.suppress(RuntimeError), turns.take("a"):
            raise RuntimeError
        assert turns._queues == {}

    play(test(), LONG_S)


def test_one_that_left_early_and_ends_late_takes_no_queue_away() -> None:
    async def test() -> None:
        turns = Turns(PATIENT)
        with contextlib.ExitStack() as long:
            long.enter_context(turns.take("a")).leave()
            with turns.take("a"):
                pass
            with turns.take("a") as first:
                await first.wait(stay)
                long.close()
                with turns.take("a") as second:
                    waiting = asyncio.ensure_future(second.wait(stay))
                    assert await have_begun(waiting) == [False]
                    first.leave()
                    await waiting
        assert turns._queues == {}

    play(test(), LONG_S)


def test_who_is_cancelled_while_waiting_lets_the_next_go_on() -> None:
    async def test() -> None:
        turns = Turns(PATIENT)

        with turns.take("a") as first:
            await first.wait(stay)
            with turns.take("a") as second:
                waiting = asyncio.ensure_future(second.wait(stay))
                await have_begun(waiting)
                waiting.cancel()
            with turns.take("a") as third:
                first.leave()
                await third.wait(stay)
        assert turns._queues == {}

    play(test(), LONG_S)


def test_a_stop_refuses_what_came_before_it_but_what_is_carried_out_keeps_its_place() -> None:
    async def test() -> None:
        turns = Turns(PATIENT)
        with turns.take("a") as first, turns.take("a") as second, turns.take(None) as stop:
            await first.wait(stay)
            with turns.take("a") as later:
                stop.stop()
                for turn in (first, second):
                    with pytest.raises(Problem, match="Stop was pressed"):
                        turn.check()
                waiting = asyncio.ensure_future(later.wait(stay))
                assert await have_begun(waiting) == [False]
                first.leave()
                assert await have_begun(waiting) == [True]

    play(test(), LONG_S)
