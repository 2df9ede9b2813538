from typing import Any, cast

from opensuction.controller.record import State
from opensuction.kernel.interface import NO_REQUESTS, RESET, START
from opensuction.simulation import trace
from opensuction.simulation.trace import InputLog, InputSpan

ONE, OTHER = (cast(State, name) for name in ("one", "other"))
"""States: the log only keeps them."""


def span(first: int, ticks: int, **given: Any) -> InputSpan:
    return InputSpan(first, ticks, 100 + first, **{"requests": NO_REQUESTS, **given})


def test_pieces_that_go_on_are_one_span_with_the_first_state() -> None:
    log = InputLog()
    log.note(span(0, 10, requests=START), ONE)
    log.note(span(10, 5), OTHER)
    assert log.spans == [span(0, 15, requests=START, set_by=trace.BEGUN, state=ONE)]


def test_a_button_a_late_link_and_a_silent_controller_begin_a_span() -> None:
    log = InputLog()
    log.note(span(0, 10), ONE)
    log.note(span(10, 5, requests=RESET), OTHER)
    log.note(span(15, 5, late_until_tick=117), OTHER)
    log.note(span(20, 5, runs=False), OTHER)
    assert [(one.first, one.ticks) for one in log.spans] == [(0, 10), (10, 5), (15, 5), (20, 5)]
    assert [one.state for one in log.spans[1:]] == [None, None, None]


def test_a_state_that_was_set_begins_a_span_and_stands_in_it() -> None:
    log = InputLog()
    log.note(span(0, 10), ONE)
    log.set_state(trace.RESTARTED)
    log.note(span(10, 5), OTHER)
    assert log.spans[1] == span(10, 5, set_by=trace.RESTARTED, state=OTHER)


def test_what_is_played_anew_takes_the_place_of_what_was_noted() -> None:
    log = InputLog()
    log.note(span(0, 10), ONE)
    log.set_state(trace.EXPIRED)
    log.note(span(10, 20), OTHER)
    log.note(span(10, 4), OTHER)
    log.note(span(14, 6, runs=False), OTHER)
    assert [(one.first, one.ticks) for one in log.spans] == [(0, 10), (10, 4), (14, 6)]
    assert log.spans[1].set_by == trace.EXPIRED
    assert log.spans[2].set_by == ""


def test_a_span_that_is_cut_by_what_is_played_anew_ends_there() -> None:
    log = InputLog()
    log.note(span(0, 10), ONE)
    log.note(span(10, 20), OTHER)
    log.note(span(16, 3, runs=False), OTHER)
    assert [(one.first, one.ticks) for one in log.spans] == [(0, 16), (16, 3)]
