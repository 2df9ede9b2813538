"""How much faster than real time the closed loop runs, trace included."""

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Tell
from benchmarks.timing import best_s
from opensuction.control.compensation import KIND_OF_NAME
from opensuction.controller import machine_profile
from opensuction.kernel.requests import NO_REQUESTS, START
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from opensuction.twin.machine import machine

EXCITED_S = machine_profile.EXCITATION.duration_s


@pytest.mark.parametrize("compensation", KIND_OF_NAME)
def test_cycle(benchmark: BenchmarkFixture, tell: Tell, compensation: str) -> None:
    rig = rigs.rig("bench", seed=1)
    kind = KIND_OF_NAME[compensation]
    loop, start = rigs.assemble(rig, PAPER, kind, rigs.identify(rig).calibration, run=2)
    table = trace.rows(60.0)
    _, ticks = closed_loop.run(loop, start, START, table)
    shortest_s = best_s(benchmark, lambda: closed_loop.run(loop, start, START, table), rounds=15)
    factor, tick_ns = ticks * DT_S / shortest_s, shortest_s / ticks * 1e9
    benchmark.extra_info.update(realtime_factor=factor, ns_per_tick=tick_ns)
    tell(f"cycle, {compensation}: {factor:,.0f} times real time, {tick_ns:.0f} ns a tick")


def test_identification(benchmark: BenchmarkFixture, tell: Tell) -> None:
    rig = rigs.rig("bench", seed=1)
    factor = EXCITED_S / best_s(benchmark, lambda: rigs.identify(rig), rounds=5)
    benchmark.extra_info["realtime_factor"] = factor
    tell(f"identification, excitation and fit: {factor:,.0f} times real time")


def test_reading_a_machine(benchmark: BenchmarkFixture) -> None:
    """A call from Python into compiled code with nested records: its floor."""
    rig = rigs.rig("bench", seed=1)
    kind = KIND_OF_NAME["none"]
    _, state = rigs.assemble(rig, PAPER, kind, rigs.uncalibrated(rig.profile), run=2)
    benchmark(machine.read, rig.machine, state.machine)


def test_one_tick_from_python(benchmark: BenchmarkFixture) -> None:
    """What a real-time loop pays that calls the compiled tick from Python."""
    rig = rigs.rig("bench", seed=1)
    kind = KIND_OF_NAME["none"]
    loop, state = rigs.assemble(rig, PAPER, kind, rigs.uncalibrated(rig.profile), run=2)
    benchmark(closed_loop.run, loop, state, NO_REQUESTS, trace.rows(DT_S))
