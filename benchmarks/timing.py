"""Typed front of pytest-benchmark."""

from collections.abc import Callable, Mapping
from math import nan
from time import thread_time

from pytest_benchmark.fixture import BenchmarkFixture


def is_timed(benchmark: BenchmarkFixture) -> bool:
    """True unless ``--benchmark-disable`` is given, by which everything runs once only."""
    return not benchmark.disabled


def best_s(
    benchmark: BenchmarkFixture, function: Callable[[], object], rounds: int, warm: bool = True
) -> float:
    """Shortest time of some rounds of a call, s; nan where nothing is timed.

    warm: run it once before, so that neither compiling nor fresh pages of memory are counted.
    """
    benchmark.pedantic(function, rounds=rounds, warmup_rounds=int(warm))  # type: ignore[no-untyped-call]
    if benchmark.stats is None:
        return nan
    return float(benchmark.stats.stats.min)


def interleaved_s(
    benchmark: BenchmarkFixture, functions: Mapping[str, Callable[[], object]], rounds: int
) -> dict[str, float]:
    """Shortest processor time of each function, s, called in turn.

    Whoever else uses the computer slows them all alike, so their ratios hold where their times
    do not. Each is called once before. Where nothing is timed, each is called once; all are nan.
    """
    shortest_s = dict.fromkeys(functions, float("inf"))

    def call_each() -> None:
        for name, function in functions.items():
            begin = thread_time()
            function()
            shortest_s[name] = min(shortest_s[name], thread_time() - begin)

    if is_timed(benchmark):
        for function in functions.values():
            function()
    best_s(benchmark, call_each, rounds)
    return shortest_s if is_timed(benchmark) else dict.fromkeys(functions, nan)
