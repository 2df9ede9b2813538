"""Typed front of pytest-benchmark."""

from collections.abc import Callable

from pytest_benchmark.fixture import BenchmarkFixture


def best_s(
    benchmark: BenchmarkFixture, function: Callable[[], object], rounds: int, warm: bool = True
) -> float:
    """Shortest time of some rounds of a call, s.

    warm: run it once before, so that neither compiling nor fresh pages of memory are counted.
    """
    benchmark.pedantic(function, rounds=rounds, warmup_rounds=int(warm))  # type: ignore[no-untyped-call]
    assert benchmark.stats is not None
    return float(benchmark.stats.stats.min)
