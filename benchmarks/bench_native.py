"""A third of a tick, compiled by numba and written by hand in C: how far from the metal we are.

Both do the same arithmetic in the same order, so their results are compared bit for bit.
"""

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Component, Tell
from benchmarks.native import layout
from benchmarks.timing import interleaved_s
from opensuction.control import backlash_inverse, compensation, preview, servo
from opensuction.control.backlash_inverse import HeadState
from opensuction.control.compensation import CompensationKind
from opensuction.control.motion_profile import HeadLimits
from opensuction.control.preview import RunIn
from opensuction.control.servo import Servo, ServoState
from opensuction.evidence.benchmark import plant_run
from opensuction.hysteresis import play, play_sum
from opensuction.hysteresis.play_sum import PlaySum
from opensuction.kernel import arithmetic
from opensuction.kernel.compiled import compiled
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from opensuction.twin.conduit.play_line import TransmissionKind
from opensuction.twin.machine import dc_axis, transmission
from opensuction.twin.machine import transmission as transmission_model
from opensuction.twin.machine.dc_axis import AxisMotion, DcAxis
from opensuction.twin.machine.transmission import Transmission, TransmissionState

SOURCE = Path(__file__).parent / "native" / "third.c"
FLAGS = ("-O2", "-std=c11", "-ffp-contract=off", "-fPIC", "-shared")
"""No fast-math and no fused products: those would be other results."""
PROCESSORS = {"any processor": (), "this processor": ("-march=native",)}
"""Compiler flags by what the C is compiled for. Numba compiles for the processor it runs on."""
COLUMNS = 4
"""Head command, voltage, encoder, tip."""

Array = npt.NDArray[np.float64]


class Third(NamedTuple):
    """What a third of a tick is set to."""

    plays: PlaySum
    limits: HeadLimits
    run_in: RunIn
    servo: Servo
    axis: DcAxis
    transmission: Transmission


class ThirdState(NamedTuple):
    """What it changes."""

    head: HeadState
    servo: ServoState
    motion: AxisMotion
    transmission: TransmissionState


RECORDS = (Third, ThirdState, preview.Goal, preview.Ahead)
"""Records that the C source uses, besides those nested in them."""
CONSTANTS = {
    "PLAYS": play_sum.PLAYS,
    "ENGAGED_MM": play_sum.ENGAGED_MM,
    "STEEPEST": backlash_inverse.STEEPEST,
    "TOUCH_MM": preview.TOUCH_MM,
    "EARLY_MM": preview.EARLY_MM,
    "FOLLOWED": preview.FOLLOWED,
    "CONDUIT_PLAYS": play.PLAYS,
    "CONDUIT_OF_PLAYS": TransmissionKind.PLAYS,
    "CREEP_MM_PER_S": transmission_model.VELOCITY_MM_PER_S,
    "TINY": arithmetic.TINY,
}
"""Constants of the core by their names in C."""


@compiled
def run(third: Third, start: ThirdState, demand: Array, dt_s: float, trace: Array) -> None:
    """Ticks under a demand as `ideal_loop.Course` has it; a row of ``trace`` for each."""
    head, memory, motion, conduit = start.head, start.servo, start.motion, start.transmission
    for tick in range(demand.shape[0]):
        reading = dc_axis.encoder(third.axis, motion)
        goal = preview.aim_ahead(
            third.run_in, demand[tick, 0], demand[tick, 1], demand[tick, 2], demand[tick, 3]
        )
        head = preview.step(third.plays, third.limits, head, goal, dt_s)
        memory, volts = servo.step(
            third.servo, memory, head.head_mm, head.head_mm_per_s, reading, dt_s
        )
        motion = dc_axis.step(third.axis, motion, volts, True, 0.0, dt_s)
        conduit = transmission.step(third.transmission, conduit, motion.position, dt_s)
        trace[tick, 0] = head.head_mm
        trace[tick, 1] = volts
        trace[tick, 2] = reading
        trace[tick, 3] = conduit.tip_mm


def compile_native(folder: Path, compiler: Path) -> dict[str, ctypes.CDLL]:
    """The C loop with the core's records, compiled into a folder for each of `PROCESSORS`."""
    (folder / "records.h").write_text(layout.write_header(RECORDS, CONSTANTS))
    found = {}
    for number, (name, flags) in enumerate(PROCESSORS.items()):
        library = folder / f"third-{number}.so"
        options = [*FLAGS, *flags, f"-I{folder}", f"-o{library}"]
        subprocess.run([compiler, *options, SOURCE, "-lm"], check=True)
        found[name] = ctypes.CDLL(str(library))
    return found


def bench_cycle() -> tuple[Third, ThirdState, Array]:
    """The bench under `preview`, identified, and the demand of the paper's cycle."""
    rig = rigs.rig("bench", seed=1)
    kind, calibration = CompensationKind.PREVIEW, rigs.identify(rig).calibration
    loop, state = rigs.assemble(rig, PAPER, kind, calibration, run=2)
    settings, machine = loop.controller, state.machine
    chosen = settings.compensation
    third = Third(
        plays=chosen.plays,
        limits=chosen.limits,
        run_in=chosen.run_in,
        servo=settings.insertion_servo,
        axis=rig.machine.insertion_axis,
        transmission=rig.machine.transmission,
    )
    start = ThirdState(
        head=compensation.park(chosen, settings.parked),
        servo=ServoState(0.0, 0.0),
        motion=machine.insertion,
        transmission=machine.transmission,
    )
    return third, start, plant_run.cycle_course(settings.plan).demand


def test_a_third_of_a_tick(
    benchmark: BenchmarkFixture, tell: Tell, tmp_path: Path, component: Component
) -> None:
    libraries = compile_native(tmp_path, component("gcc"))
    third, start, demand = bench_cycle()
    ticks = demand.shape[0]
    packed = (layout.pack(third), layout.pack(start), demand)
    traces = {name: np.zeros((ticks, COLUMNS)) for name in ("numba", *PROCESSORS)}

    def native(name: str) -> Callable[[], object]:
        *given, trace = (ctypes.c_void_p(one.ctypes.data) for one in (*packed, traces[name]))
        arguments = (*given, ctypes.c_int64(ticks), ctypes.c_double(DT_S), trace)
        return lambda: libraries[name].run(*arguments)

    functions: dict[str, Callable[[], object]] = {name: native(name) for name in PROCESSORS}
    functions["numba"] = lambda: run(third, start, demand, DT_S, traces["numba"])
    shortest_s = interleaved_s(benchmark, functions, rounds=100)
    assert np.ptp(traces["numba"][:, 3]) > 80.0  # the tip has gone all the way
    for name in PROCESSORS:
        assert np.array_equal(traces["numba"], traces[name])
        ratio = shortest_s["numba"] / shortest_s[name]
        benchmark.extra_info[f"numba_over_c, {name}"] = ratio
        numba_ns, c_ns = (shortest_s[each] / ticks * 1e9 for each in ("numba", name))
        tell(
            f"a third of a tick, numba over C (cc -O2 for {name}): {ratio:.2f} "
            f"(numba {numba_ns:.0f} ns, C {c_ns:.0f} ns)"
        )
