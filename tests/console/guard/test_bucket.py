"""Rate limit of requests."""

from opensuction.console.guard import limits
from opensuction.console.guard.limits import Buckets


class Clock:
    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def test_as_many_at_once_as_it_holds_and_then_as_fast_as_it_fills() -> None:
    clock = Clock()
    made = Buckets(2.0, 3.0, clock)
    assert [made.take("a") for _ in range(4)] == [0.0, 0.0, 0.0, 0.5]
    clock.now_s = 0.5
    assert made.take("a") == 0.0
    assert made.take("a") > 0.0


def test_a_refused_try_costs_nothing_and_the_wait_is_long_enough() -> None:
    clock = Clock()
    made = Buckets(0.1, 1.0, clock)
    made.take("a")
    waits = [made.take("a") for _ in range(50)]
    assert set(waits) == {10.0}
    clock.now_s = 10.0
    assert made.take("a") == 0.0


def test_one_who_floods_takes_nothing_from_another() -> None:
    made = Buckets(1.0, 2.0, Clock())
    for _ in range(100):
        made.take("flood")
    assert made.take("nurse") == 0.0


def test_it_never_holds_more_than_it_can() -> None:
    clock = Clock()
    made = Buckets(5.0, 2.0, clock)
    made.take("a")
    clock.now_s = 1e6
    assert [made.take("a") for _ in range(3)][:2] == [0.0, 0.0]
    assert made.take("a") > 0.0


def test_many_names_take_no_memory_for_ever() -> None:
    made = Buckets(1.0, 1.0, Clock())
    for number in range(2 * limits.KEPT):
        made.take(str(number))
    assert len(made._kept) == limits.KEPT
