"""A third of a tick, compiled by numba and written by hand in C: how far from the metal we are.

Both do the same arithmetic in the same order, so their results are compared bit for bit.
"""

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints

import numpy as np
import numpy.typing as npt
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Tell
from benchmarks.timing import interleaved_s
from opensuction.control import compensation, preview, servo
from opensuction.control.compensation import CompensationKind
from opensuction.control.exact_inverse import HeadState
from opensuction.control.head_path import HeadLimits
from opensuction.control.preview import RunIn
from opensuction.control.servo import Servo, ServoState
from opensuction.hysteresis.play_sum import PlaySum
from opensuction.kernel.compiled import compiled
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import ideal_loop
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from opensuction.twin.machine import dc_axis, transmission
from opensuction.twin.machine.dc_axis import AxisMotion, DcAxis
from opensuction.twin.machine.transmission import Transmission, TransmissionState

SOURCE = Path(__file__).parent / "native" / "third.c"
FLAGS = ("-O2", "-std=c11", "-ffp-contract=off", "-fPIC", "-shared")
"""No fast-math and no fused products: those would be other results."""
COMPILER = shutil.which("cc")
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


def structure(record: Any) -> ctypes.Structure:
    """A record as C has it: the same fields in the same order, tuples as arrays."""
    types = get_type_hints(type(record))
    fields = {name: member(value, types[name]) for name, value in record._asdict().items()}
    kinds = [(name, type(value)) for name, value in fields.items()]
    made = type(type(record).__name__, (ctypes.Structure,), {"_fields_": kinds})
    filled: ctypes.Structure = made(*fields.values())
    return filled


def member(value: Any, kind: type) -> Any:
    """A field of a record as C has it."""
    if hasattr(value, "_fields"):
        return structure(value)
    if isinstance(value, tuple):
        return (ctypes.c_double * len(value))(*value)
    return ctypes.c_bool(value) if kind is bool else ctypes.c_double(value)


def native(folder: Path) -> ctypes.CDLL:
    """The C loop, compiled into a folder."""
    assert COMPILER is not None
    library = folder / "third.so"
    subprocess.run([COMPILER, *FLAGS, "-o", library, SOURCE, "-lm"], check=True)
    return ctypes.CDLL(str(library))


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
    return third, start, ideal_loop.course(settings.plan).demand


@pytest.mark.skipif(COMPILER is None, reason="no C compiler (cc) was found")
def test_a_third_of_a_tick(benchmark: BenchmarkFixture, tell: Tell, tmp_path: Path) -> None:
    third, start, demand = bench_cycle()
    ticks = demand.shape[0]
    by_numba, by_hand = np.zeros((ticks, COLUMNS)), np.zeros((ticks, COLUMNS))
    library, settings, begun = native(tmp_path), structure(third), structure(start)
    assert library.size_of_third() == ctypes.sizeof(settings)
    assert library.size_of_state() == ctypes.sizeof(begun)
    pointers = [ctypes.c_void_p(table.ctypes.data) for table in (demand, by_hand)]

    def call_native() -> None:
        library.run(
            ctypes.byref(settings),
            ctypes.byref(begun),
            pointers[0],
            ctypes.c_int64(ticks),
            ctypes.c_double(DT_S),
            pointers[1],
        )

    functions = {
        "numba": lambda: run(third, start, demand, DT_S, by_numba),
        "C": call_native,
    }
    shortest_s = interleaved_s(benchmark, functions, rounds=30)
    assert np.array_equal(by_numba, by_hand)
    assert np.ptp(by_hand[:, 3]) > 80.0  # the tip has gone all the way
    ratio = shortest_s["numba"] / shortest_s["C"]
    benchmark.extra_info["numba_over_c"] = ratio
    each = ", ".join(f"{name} {s / ticks * 1e9:.0f} ns" for name, s in shortest_s.items())
    tell(f"a third of a tick, numba over C ({Path(COMPILER or '').name} -O2): {ratio:.2f} ({each})")
