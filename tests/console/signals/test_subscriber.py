"""A client that is too slow loses messages, and is told; what waits for it does not grow."""

import asyncio
import json

from opensuction.console.signals.channel import CHANNELS, Picker, decode
from opensuction.console.signals.feed import STALLED_S, WAITING_MOST, Subscriber, say
from tests.console.play import play
from tests.console.signals.block import block_of, rows_of

CHOSEN = (CHANNELS["inputs.readings.head_mm"],)
MESSAGE = Picker(CHOSEN).encode(block_of(rows_of(10)))


def take_all(one: Subscriber, count: int) -> list[bytes | str]:
    async def take() -> list[bytes | str]:
        return [await asyncio.wait_for(one.take(), 1.0) for _ in range(count)]

    return play(take(), 20.0)


def test_the_next_frame_tells_of_all_rows_that_were_lost() -> None:
    one = Subscriber(CHOSEN)
    for _ in range(WAITING_MOST):
        one.put_rows(MESSAGE, 10, 0)
    one.put_rows(MESSAGE, 10, 0)
    one.put_rows(MESSAGE, 10, 5)
    kept = take_all(one, WAITING_MOST)
    assert [decode(told).missed for told in kept if isinstance(told, bytes)] == [0] * WAITING_MOST
    one.put_rows(MESSAGE, 10, 0)
    one.put_rows(MESSAGE, 10, 0)
    again = [decode(told).missed for told in take_all(one, 2) if isinstance(told, bytes)]
    assert again == [25, 0]


def test_what_waits_never_grows() -> None:
    one = Subscriber(CHOSEN)
    for _ in range(100 * WAITING_MOST):
        one.put_rows(MESSAGE, 10, 0)
        one.put_text(say("event"))
    assert len(take_all(one, WAITING_MOST)) == WAITING_MOST
    lost = json.loads(str(take_all(one, 1)[0]))
    assert lost == {"kind": "lost", "messages": 100 * WAITING_MOST - WAITING_MOST // 2}


def test_who_takes_nothing_is_stalled_after_a_while_and_not_before() -> None:
    one = Subscriber(CHOSEN)
    assert not one.is_stalled(0.0)
    for _ in range(WAITING_MOST):
        one.put_rows(MESSAGE, 10, 0)
    assert not one.is_stalled(1.0)
    assert not one.is_stalled(1.0 + STALLED_S)
    assert one.is_stalled(1.1 + STALLED_S)
    take_all(one, 1)
    assert not one.is_stalled(1.2 + STALLED_S)
    one.put_rows(MESSAGE, 10, 0)
    assert not one.is_stalled(1.3 + STALLED_S)
