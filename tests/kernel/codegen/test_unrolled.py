"""Loops that are written out: the loop, the straight line and the machine code agree to the bit."""

import inspect
import random
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from opensuction.hysteresis import play, play_sum
from opensuction.hysteresis.bank import turning_point
from opensuction.hysteresis.play_sum import PlaySum
from opensuction.kernel.codegen.unrolled import chooser, unrolled, write_out
from opensuction.kernel.compiled import compiled
from opensuction.procedure.cycle import check
from opensuction.safety.alarm import alarm_clock
from opensuction.safety.condition_mask import HANDLINGS
from opensuction.twin.conduit import play_line
from opensuction.twin.conduit.play_line import PlayLines

Draw = Callable[[random.Random], tuple[Any, ...]]


def _numbers(source: random.Random, count: int) -> tuple[float, ...]:
    """Among them zeros of both signs, and numbers that a sum must not regroup."""
    odd = (0.0, -0.0, 1e-300, 1e16, -1e16)
    return tuple(
        source.choice(odd) if source.random() < 0.2 else source.uniform(-40.0, 40.0)
        for _ in range(count)
    )


def _twelve(source: random.Random) -> tuple[float, ...]:
    return _numbers(source, play.PLAYS)


def _sixteen(source: random.Random) -> tuple[float, ...]:
    return _numbers(source, play_sum.PLAYS)


def _sum(source: random.Random) -> PlaySum:
    return PlaySum(_sixteen(source), _sixteen(source), source.uniform(0.0, 1.0), 1.0, 1e-3)


def _lines(source: random.Random) -> PlayLines:
    spans = tuple(source.uniform(0.1, 100.0) for _ in range(play.PLAYS))
    lows, low, middle, high, widths = (_twelve(source) for _ in range(5))
    return PlayLines(lows, spans, low, middle, high, widths)


def _clocks(bits: tuple[int, ...]) -> Draw:
    delays = sorted({one.delay_s for one in HANDLINGS})

    def draw(source: random.Random) -> tuple[Any, ...]:
        clocks = tuple(source.choice((0.0, *delays)) for _ in bits)
        return clocks, source.getrandbits(62), source.getrandbits(62), 1e-3

    return draw


FUNCTIONS: dict[str, tuple[Any, Draw]] = {
    "mature": (alarm_clock.mature, _clocks(alarm_clock.DELAYED)),
    "rise": (alarm_clock.rise, _clocks(alarm_clock.RISING)),
    "scale": (play.scale_bundle, lambda r: (_twelve(r), r.uniform(0.0, 2.0))),
    "bundle": (play.step_bundle, lambda r: (_twelve(r), _twelve(r), r.uniform(-40.0, 40.0))),
    "retracted": (play_sum.retracted_positions_mm, lambda r: (_sum(r), r.uniform(-40.0, 40.0))),
    "sum": (play_sum.step, lambda r: (_sum(r), _sixteen(r), r.uniform(-40.0, 40.0))),
    "weigh": (play_sum._weigh, lambda r: (r.uniform(-9.0, 9.0), _sixteen(r), _sixteen(r))),
    "left": (play_sum._left_mm, lambda r: (_sum(r), _sixteen(r), 3.0, r.choice((-1.0, 1.0)))),
    "engage": (play_sum._engage, lambda r: (_sum(r), _sixteen(r), r.uniform(0.0, 50.0))),
    "slope": (play_sum._slope, lambda r: (_sum(r), _sixteen(r), 1e-9)),
    "turns": (turning_point._pack, lambda r: (np.array(_sixteen(r)),)),
    "lines": (play_line.read_out_mm, lambda r: (_lines(r), _twelve(r))),
    "chooser": (
        check.item_limit_s,
        lambda r: (_numbers(r, len(check.CheckItem)), r.randrange(len(check.CheckItem))),
    ),
}


def _bits(found: Any) -> Any:
    if isinstance(found, tuple):
        return tuple(map(_bits, found))
    return struct.pack("<d", found) if isinstance(found, float) else found


@pytest.mark.parametrize("name", FUNCTIONS)
def test_loop_straight_line_and_machine_code_agree_to_the_bit(name: str) -> None:
    function, draw = FUNCTIONS[name]
    straight = function.py_func
    loop = straight.__wrapped__
    assert "for" in inspect.getsource(loop)
    source = random.Random(38)
    for _ in range(300):
        arguments = draw(source)
        expected = _bits(loop(*arguments))
        assert _bits(straight(*arguments)) == expected
        assert _bits(function(*arguments)) == expected


def test_turns_of_a_tuple_come_back_from_the_array() -> None:
    turns, values = _sixteen(random.Random(1)), np.zeros(turning_point.ROOM)
    turning_point._unpack(turns, values)
    assert turning_point._pack(values) == turns


COUNT, PAIRS, NAMES = 3, ((1, 0.5), (2, -0.0)), ("a", "b")


@unrolled
def _nested(values: tuple[float, ...]) -> float:
    total = 0.0
    for i in range(COUNT):
        for j in range(i):
            total += values[i] * values[j]
        if total > 100.0:
            return -1.0
    for i, (_, weight) in enumerate(PAIRS):
        total += weight * values[i]
    return total


@compiled
def _twice(values: tuple[float, ...]) -> float:
    return 2.0 * _nested(values)


def test_loops_lie_within_loops_and_go_over_pairs() -> None:
    assert _nested((1.0, 2.0, 3.0)) == 2.0 + 3.0 + 6.0 + 0.5
    assert _nested((1.0, 20.0, 30.0)) == -1.0
    assert _twice((1.0, 2.0, 3.0)) == 23.0


def test_nothing_of_a_loop_is_left() -> None:
    straight = _nested.py_func  # type: ignore[attr-defined]
    called = set(straight.__code__.co_names)
    assert called.isdisjoint({"range", "enumerate", "COUNT", "PAIRS"})
    assert straight.__name__ == "_nested"


def test_a_chooser_of_one_number_has_no_choice() -> None:
    assert chooser(1)((7.0,), 0) == 7.0


def _over_arguments(values: tuple[float, ...]) -> float:
    total = 0.0
    for value in values:
        total += value
    return total


def _breaks(values: tuple[float, ...]) -> float:
    total = 0.0
    for i in range(COUNT):
        if values[i] < 0.0:
            break
        total += values[i]
    return total


def _assigns(values: tuple[float, ...]) -> float:
    total = 0.0
    for i in range(COUNT):
        total += values[i]
        i = 0  # noqa: PLW2901
    return total + i


def _over_words(values: tuple[float, ...]) -> float:
    for name in NAMES:
        if name == "b":
            return values[0]
    return 0.0


def _made(count: int) -> Callable[[tuple[float, ...]], float]:
    def last(values: tuple[float, ...]) -> float:
        return values[count - 1]

    return last


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (_over_arguments, r"_over_arguments: the loop of its line 3 goes over .*'values'"),
        (_breaks, r"_breaks: the loop of its line 3 has break, continue or else"),
        (_assigns, r"_assigns: the loop of its line 3 gives i another value"),
        (_over_words, r"_over_words: the loop of its line 2 has name = 'a', which is no number"),
        (_made(2), r"refers to count elsewhere than in what a loop goes over"),
    ],
)
def test_a_loop_that_cannot_be_written_out_is_refused(
    function: Callable[..., object], said: str
) -> None:
    with pytest.raises(TypeError, match=said):
        write_out(function)


def test_without_machine_code_the_loop_itself_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("numba.config.DISABLE_JIT", True)
    assert unrolled(_over_arguments) is _over_arguments
