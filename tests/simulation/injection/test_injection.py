"""Runs with faults on the bench: when they come, what notices them, and where it ends."""

import math

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import START
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.injection import injection, invariant
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.simulation.injection.injection import Detector, Injected, InjectedRun
from opensuction.simulation.injection.invariant import SafeBounds
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault

BOUNDS = SafeBounds(boundary_mm=1.0, vented_mmhg=5.0, vacuum_mmhg=150.0, contact_n=0.01)
NEVER = FaultInstant(None, 179.0)
"""After any cycle is over."""


def ready() -> tuple[Loop, LoopState]:
    rig = rigs.rig("bench", 1)
    return rigs.assemble(
        rig, PAPER, CompensationKind.EXACT_INVERSE, rigs.uncalibrated(rig.profile), 2
    )


LOOP, PARKED = ready()


def at(phase: Phase, after_s: float = 0.0) -> FaultInstant:
    return FaultInstant(phase, after_s)


def run(*injections: Injection, resets: int = 0) -> InjectedRun:
    return injection.run(LOOP, PARKED, injections, resets=resets)


def single(
    fault: Fault, instant: FaultInstant, strength: float = 0.0
) -> tuple[InjectedRun, Injected]:
    found = run(Injection(fault, instant, strength))
    return found, found.faults[0]


@pytest.fixture(scope="module")
def healthy() -> Columns:
    _, columns = trace.record(LOOP, PARKED, START, 60.0)
    return columns


def same(first: Columns, second: Columns, ticks: int) -> bool:
    return all(
        np.array_equal(first[name][:ticks], second[name][:ticks], equal_nan=True) for name in first
    )


def test_without_a_fault_the_rows_are_those_of_the_healthy_loop(healthy: Columns) -> None:
    """Bit for bit, also where every message goes through a link that could fail."""
    ticks = healthy["time_s"].size
    plain = run()
    linked = run(Injection(Fault.TICK_LATE, NEVER, 1.0))
    assert same(healthy, plain.columns, ticks)
    assert same(plain.columns, linked.columns, plain.columns["time_s"].size)
    assert math.isnan(linked.faults[0].at_s)
    assert linked.faults[0].notice is None


@pytest.mark.parametrize(
    ("fault", "strength"), [(Fault.PUMP_LOST, 0.0), (Fault.VACUUM_SENSOR_OFFSET, -60.0)]
)
def test_nothing_changes_before_the_instant(
    healthy: Columns, fault: Fault, strength: float
) -> None:
    found, injected = single(fault, at(Phase.SUCTIONING, 1.2345), strength)
    first = round(injected.at_s / DT_S)
    began = int(np.argmax(healthy["phase"] == Phase.SUCTIONING))
    assert first == began + 1234  # to the tick
    assert same(healthy, found.columns, first)
    name = "truth.line_vacuum_mmhg" if strength == 0.0 else "readings.line_vacuum_mmhg"
    assert found.columns[name][first + 5] < healthy[name][first + 5]


def test_a_fault_that_comes_with_a_phase_acts_from_its_second_tick(healthy: Columns) -> None:
    _, injected = single(Fault.PUMP_LOST, at(Phase.OPENING))
    began = int(np.argmax(healthy["phase"] == Phase.OPENING))
    assert round(injected.at_s / DT_S) == began + 1


def test_two_faults_come_each_at_its_instant() -> None:
    found = run(
        Injection(Fault.LINE_LEAK, at(Phase.SUCTIONING, 1.0), 1.0),
        Injection(Fault.VALVE_JAMMED, at(Phase.SUCTIONING, 2.0), 0.0),
    )
    leak, jam = found.faults
    assert jam.at_s - leak.at_s == pytest.approx(1.0)


def test_a_trip_is_named_with_its_time() -> None:
    found, injected = single(Fault.ENCODER_INVALID, at(Phase.SUCTIONING, 1.0))
    assert injected.notice is not None
    assert injected.notice.detector == Detector.TRIP
    assert injected.notice.title == "head-reading-invalid"
    # Five ticks in a row without a valid reading; the first is that of the instant.
    assert injected.notice.time_s - injected.at_s == pytest.approx(0.004)
    assert found.columns["phase"][-1] == Phase.HALTED


@pytest.mark.parametrize(
    ("fault", "item"), [(Fault.PUMP_LOST, "vacuum-builds"), (Fault.RELIEF_FAILED, "relief-opens")]
)
def test_a_failed_item_of_the_pre_use_test_is_named(fault: Fault, item: str) -> None:
    _, injected = single(fault, AT_START)
    assert injected.notice is not None
    assert injected.notice.detector == Detector.CHECK
    assert injected.notice.title == item


def test_a_fault_that_nothing_notices_is_said_to_be_so() -> None:
    # Without its current a sound drive moves as before; only a jam would be noticed later.
    found, injected = single(Fault.CURRENT_SENSOR_DEAD, AT_START)
    assert injected.notice is None
    assert found.columns["phase"][-1] == Phase.PARKED


def test_an_expired_catheter_is_refused_its_start() -> None:
    found, injected = single(Fault.CATHETER_EXPIRED, AT_START, 25.0)
    assert injected.notice is not None
    assert injected.notice.detector == Detector.REFUSAL
    assert injected.notice.code == Refusal.CATHETER_LIFE_OVER
    assert np.all(found.columns["phase"] == Phase.PARKED)


def safe_after_s(found: InjectedRun, *names: str) -> float:
    held = invariant.holds(found.columns, names, BOUNDS)
    at_s = found.faults[0].at_s
    return invariant.safe_s(found.columns, held, at_s) - at_s


def test_drives_without_a_controller_bring_the_catheter_out_and_the_next_one_goes_on() -> None:
    stopped = Injection(Fault.CONTROLLER_STOPPED, at(Phase.SUCTIONING, 2.0), 20.0)
    found = run(stopped, resets=2)
    notice = found.faults[0].notice
    assert notice is not None
    assert notice.detector == Detector.DRIVE
    assert notice.title == "message-late"
    assert notice.time_s - found.faults[0].at_s == pytest.approx(0.005)
    # 90 mm and the gap at half of the no-load speed, 9 mm/s.
    assert 9.0 < safe_after_s(found, "tip-outside", "no-suction", "vented") < 15.0
    assert found.columns["phase"][-1] == Phase.PARKED


@pytest.mark.parametrize("outage_s", [0.001, 0.015, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("phase", [Phase.INSERTING, Phase.SUCTIONING, Phase.WITHDRAWING])
def test_a_new_controller_that_finds_the_head_inside_brings_it_out_unasked(
    phase: Phase, outage_s: float
) -> None:
    """It comes back before the drives are done, or have begun."""
    stopped = Injection(Fault.CONTROLLER_STOPPED, at(phase, 2.0), outage_s)
    left = run(stopped)
    assert left.columns["phase"][-1] == Phase.HALTED
    assert left.columns["truth.tip_mm"][-1] < BOUNDS.boundary_mm
    out_s = left.columns["time_s"][left.columns["truth.tip_mm"] > BOUNDS.boundary_mm][-1]
    # 90 mm and the gap at 17 mm/s; the drives alone are slower.
    assert out_s - left.faults[0].at_s < 8.0 + 0.2 * outage_s
    assert run(stopped, resets=1).columns["phase"][-1] == Phase.PARKED


def test_without_power_suction_ends_and_reserve_energy_brings_the_catheter_out() -> None:
    reserve, _ = single(Fault.POWER_LOST, at(Phase.SUCTIONING, 2.0))
    assert safe_after_s(reserve, "tip-outside", "no-suction", "vented", "torque-off") < 15.0
    none, _ = single(Fault.POWER_LOST_WITHOUT_RESERVE, at(Phase.SUCTIONING, 2.0))
    # The spring shuts the valve and the regulator vents, within a stroke.
    assert safe_after_s(none, "no-suction", "vented", "torque-off", "standing") < 3.0
    assert math.isnan(safe_after_s(none, "tip-outside"))


def test_lost_commands_are_noticed_by_the_drives_and_the_controller_halts() -> None:
    found, injected = single(Fault.MESSAGE_LOST, at(Phase.INSERTING, 3.0), 1.0)
    assert injected.notice is not None
    assert injected.notice.detector == Detector.DRIVE
    assert safe_after_s(found, "tip-outside", "no-suction") < 15.0


def test_the_same_seed_gives_the_same_run() -> None:
    noisy = Injection(Fault.VACUUM_SENSOR_NOISY, at(Phase.SUCTIONING, 1.0), 20.0)
    first, again, other = (
        injection.run(LOOP, PARKED, [noisy], seed=seed).columns for seed in (1, 1, 2)
    )
    ticks = min(first["time_s"].size, other["time_s"].size)
    assert same(first, again, first["time_s"].size)
    assert not same(first, other, ticks)


def test_what_cannot_be_injected_is_refused() -> None:
    with pytest.raises(InputError, match="3 faults at once"):
        run(*[Injection(Fault.PUMP_LOST, AT_START, 0.0)] * 3)
    with pytest.raises(InputError, match="before the cycle is planned"):
        run(Injection(Fault.WRONG_PRESET, AT_START, 0.0))


def test_what_the_drives_do_alone_is_no_word_of_the_controller() -> None:
    """The first sign of another fault, one that the cycle was planned with, is the same."""
    found, lost = single(Fault.POWER_LOST, at(Phase.INSERTING))
    assert lost.notice is not None
    assert lost.notice.detector == Detector.DRIVE
    assert injection.find_notice(found.columns, 0.0) != lost.notice
    assert injection.find_first_sign(found, 0.0) == lost.notice
