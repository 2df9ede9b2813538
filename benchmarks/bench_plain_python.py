"""Gain in speed by compilation: the same source, compiled and as plain Python."""

import time

from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Tell
from benchmarks.timing import best_s, is_timed
from opensuction.control.compensation import CompensationKind
from opensuction.kernel.interface import START
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from tests.conformance.plain import run_plain

SEGMENT_S = 2.0
"""Check of the pump and the first second of insertion."""


INSTANT_S = 0.1
"""Simulated instead where nothing is timed."""


def segment_s() -> float:
    """Shortest time of three for a segment of a cycle, s."""
    return shortest_s(SEGMENT_S)


def instant_s() -> float:
    """The same for its first instant."""
    return shortest_s(INSTANT_S)


def shortest_s(simulated_s: float) -> float:
    """Shortest time of three for the beginning of a cycle, s."""
    rig = rigs.rig("bench", seed=1)
    kind = CompensationKind.EXACT_INVERSE
    loop, start = rigs.assemble(rig, PAPER, kind, rigs.uncalibrated(rig.profile), run=2)
    table = trace.rows(simulated_s)
    closed_loop.run(loop, start, START, table[:10])
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        closed_loop.run(loop, start, START, table)
        times.append(time.perf_counter() - begin)
    return min(times)


def test_compiled_over_plain_python(benchmark: BenchmarkFixture, tell: Tell) -> None:
    compiled: list[float] = []
    part_s = segment_s if is_timed(benchmark) else instant_s
    best_s(benchmark, lambda: compiled.append(part_s()), rounds=3)
    compiled_s = min(compiled)
    plain_s = run_plain("benchmarks.bench_plain_python", part_s.__name__)
    assert isinstance(plain_s, float)
    benchmark.extra_info["compiled_over_plain"] = plain_s / compiled_s
    per_tick_us = plain_s / SEGMENT_S * DT_S * 1e6
    tell(
        f"compiled over plain Python: {plain_s / compiled_s:,.0f} times "
        f"(plain: {per_tick_us:.0f} us a tick)"
    )
