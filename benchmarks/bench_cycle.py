"""Speed of the closed loop as a multiple of real time, trace included."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks import reference
from benchmarks.conftest import Tell
from benchmarks.timing import best_s, interleaved_s
from opensuction.control.compensation import KIND_OF_NAME
from opensuction.controller import machine_profile
from opensuction.kernel.interface import NO_REQUESTS, START
from opensuction.procedure.planning.protocol import PAPER
from opensuction.session.choice import CycleChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.twin.machine import machine

EXCITED_S = machine_profile.EXCITATION.duration_s


ADULT = CycleChoice()


class Case(NamedTuple):
    """A cycle that is run into one trace, again and again."""

    loop: Loop
    start: LoopState
    table: npt.NDArray[np.float64]

    def run(self) -> int:
        """One run; returns its ticks."""
        return closed_loop.run(self.loop, self.start, START, self.table)[1]


def cases() -> dict[str, Case]:
    """The bench under every compensation, and a ventilated adult under the default one."""
    rig = rigs.rig("bench", seed=1)
    calibration = rigs.identify(rig).calibration
    table = trace.rows(60.0)
    found = {
        f"bench, {name}": Case(*rigs.assemble(rig, PAPER, kind, calibration, run=2), table)
        for name, kind in KIND_OF_NAME.items()
    }
    prepared = cycle_run.prepare(resolution.resolve(ADULT))
    return {**found, "adult, preview": Case(prepared.loop, prepared.start, table)}


def test_ticks(benchmark: BenchmarkFixture, tell: Tell) -> None:
    """Every tick in ticks of the reference loop, which can be compared from commit to commit."""
    assert reference.run() == reference.CHECKSUM
    chosen = cases()
    functions = {name: case.run for name, case in chosen.items()}
    shortest_s = interleaved_s(benchmark, {"reference": reference.run, **functions}, rounds=30)
    reference_ns = shortest_s["reference"] / reference.TICKS * 1e9
    tell(f"reference loop: {reference_ns:.1f} ns a tick")
    for name, case in chosen.items():
        tick_ns = shortest_s[name] / case.run() * 1e9
        factor = DT_S * 1e9 / tick_ns
        benchmark.extra_info[name] = {"reference_ticks": tick_ns / reference_ns, "ns": tick_ns}
        tell(
            f"cycle, {name}: {tick_ns / reference_ns:.2f} reference ticks a tick, {tick_ns:.0f} ns,"
            f" {factor:,.0f} times real time"
        )


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
