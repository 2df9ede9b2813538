"""A catheter that stays inside: unavoidable by physics alone, and then told."""

import math

import numpy as np
import pytest

from opensuction.safety.condition import Condition
from opensuction.simulation import rig as rigs
from opensuction.simulation.annunciation import Told
from opensuction.simulation.injection import left_inside
from opensuction.simulation.injection.fault_instant import AT_START, Injection
from opensuction.simulation.injection.left_inside import (
    HELD,
    LOOSE,
    PARTED,
    POWERLESS,
    SLIPPED,
    WIDENED,
    Unavoidable,
)
from opensuction.simulation.rig import CONNECTOR_MM
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine import dc_axis, transmission
from opensuction.twin.machine.dc_axis import AxisMotion, DcAxis

CAP_MM = 20.0
MACHINE = rigs.rig("clinical", 1, patient="child-10kg").machine


def why(*faults: tuple[Fault, float]) -> Unavoidable | None:
    came = [Injection(fault, AT_START, strength) for fault, strength in faults]
    return left_inside.find_unavoidable(MACHINE, came)


@pytest.mark.parametrize(
    ("fault", "strength", "reason"),
    [
        (Fault.MOTOR_STALLED, 0.0, HELD),
        (Fault.MOTOR_LOST, 0.0, HELD),
        (Fault.CATHETER_JAMMED, 30.0, HELD),
        (Fault.GEAR_LOST, 0.0, PARTED),
        (Fault.CLAMP_SLIPPING, 0.2, SLIPPED),
        (Fault.POWER_LOST_WITHOUT_RESERVE, 0.0, POWERLESS),
    ],
)
def test_what_takes_every_actuator_leaves_the_catheter_to_a_hand(
    fault: Fault, strength: float, reason: Unavoidable
) -> None:
    assert why((fault, strength)) == reason
    assert reason.person.startswith("Draw the catheter out by hand")


def test_a_tip_that_has_parted_is_out_of_every_reach() -> None:
    found = why((Fault.TIP_LEFT_BEHIND, 20.0))
    assert found == LOOSE
    assert "bronchoscopy" in found.person


TAKES_ALL = (
    Fault.MOTOR_STALLED,
    Fault.MOTOR_LOST,
    Fault.GEAR_LOST,
    Fault.CLAMP_SLIPPING,
    Fault.TIP_LEFT_BEHIND,
    Fault.POWER_LOST_WITHOUT_RESERVE,
)
GRADED = (Fault.CATHETER_JAMMED, Fault.MOTOR_WEAK)


@pytest.mark.parametrize(
    "fault", [one for one, row in ROWS.items() if not row.is_setup and one not in TAKES_ALL]
)
def test_a_fault_that_leaves_something_to_pull_with_excuses_nothing(fault: Fault) -> None:
    strength = ROWS[fault].default_strength
    if fault in GRADED:
        known = ROWS[fault].strength
        assert known is not None
        strength = known.least
    assert why((fault, strength)) is None


def test_a_jam_is_unavoidable_from_the_force_of_the_drive_on_less_a_hundredth_to_move_it() -> None:
    """The drive's own force, less its friction, in newton at the head."""
    axis = MACHINE.insertion_axis
    force_n = (0.99 * axis.force_v - axis.friction_v) / MACHINE.load_v_per_n
    assert why((Fault.CATHETER_JAMMED, 0.999 * force_n)) is None
    assert why((Fault.CATHETER_JAMMED, 1.001 * force_n)) == HELD
    half = (Fault.CATHETER_JAMMED, 0.6 * force_n)
    assert why(half) is None
    assert why(half, half) == HELD


@pytest.mark.parametrize("share", [0.5, 0.9, 0.99])
def test_the_gap_takes_as_long_as_all_of_the_drives_force_needs_for_it(share: float) -> None:
    """Played on the twin's own axis; the sound one has it behind it in less than half a second.

    share: of what the drive has to spare, that holds the catheter.
    """
    axis = MACHINE.insertion_axis
    jam_n = share * (axis.force_v - axis.friction_v) / MACHINE.load_v_per_n
    jam = [Injection(Fault.CATHETER_JAMMED, AT_START, jam_n)]
    faulty = ROWS[Fault.CATHETER_JAMMED].change_machine(MACHINE, jam_n)
    gap_mm = float(np.mean(MACHINE.transmission.widths_mm)) + MACHINE.transmission.stretch_mm
    motion, ticks = AxisMotion(gap_mm, 0.0, 0.0), 0
    while motion.position > 0.0 and ticks < 20_000:
        motion = dc_axis.step(faulty.insertion_axis, motion, -24.0, True, 0.0, 1e-3)
        ticks += 1
    found_s = left_inside.find_least(MACHINE, jam, CAP_MM).crossing_s
    assert found_s == pytest.approx(ticks * 1e-3, rel=0.02, abs=0.02)
    assert left_inside.find_least(MACHINE, [], CAP_MM).crossing_s < 0.5


def test_the_way_out_is_as_much_longer_as_the_force_that_is_left_is_less() -> None:
    """Played: at full voltage from rest, over the whole way; a sound drive is no longer at all."""

    def played_s(axis: DcAxis) -> float:
        gap_mm = float(np.mean(MACHINE.transmission.widths_mm)) + MACHINE.transmission.stretch_mm
        motion, ticks = AxisMotion(CAP_MM + MACHINE.patient.tube_length_mm + gap_mm, 0.0, 0.0), 0
        while motion.position > 0.0 and ticks < 60_000:
            motion = dc_axis.step(axis, motion, -24.0, True, 0.0, 1e-3)
            ticks += 1
        return ticks * 1e-3

    for lost in (0.5, 0.6, 0.7):
        weak = [Injection(Fault.MOTOR_WEAK, AT_START, lost)]
        axis = ROWS[Fault.MOTOR_WEAK].change_machine(MACHINE, lost).insertion_axis
        longer_s = played_s(axis) - played_s(MACHINE.insertion_axis)
        found_s = left_inside.find_least(MACHINE, weak, CAP_MM).longer_s
        assert found_s == pytest.approx(longer_s, abs=0.1)
    assert left_inside.find_least(MACHINE, [], CAP_MM).longer_s == 0.0


def test_a_drive_that_overcomes_nothing_never_crosses_the_gap() -> None:
    for fault, strength in ((Fault.CATHETER_JAMMED, 30.0), (Fault.MOTOR_LOST, 0.0)):
        found = left_inside.find_least(MACHINE, [Injection(fault, AT_START, strength)], CAP_MM)
        assert found == (math.inf, math.inf)


def test_a_gap_that_has_grown_by_more_than_twice_the_connector_leaves_the_tip_in_the_tube() -> None:
    """The tip lies half the gap further in than its head; the connector is what it is parked in."""
    conduit = transmission.widen(MACHINE.transmission, 1.3)
    wide = MACHINE._replace(transmission=conduit)
    limit = 1.0 + 2.0 * CONNECTOR_MM / (float(np.mean(conduit.widths_mm)) + conduit.stretch_mm)
    assert 2.0 < limit < 2.9
    for strength, reason in ((limit - 0.01, None), (limit + 0.01, WIDENED)):
        laid = Injection(Fault.CONDUIT_REROUTED, AT_START, strength)
        assert left_inside.find_unavoidable(wide, [laid]) == reason


def test_a_motor_that_is_gone_for_as_long_as_a_withdrawal_takes_is_lost() -> None:
    assert why((Fault.MOTOR_INTERMITTENT, 3.9)) is None
    assert why((Fault.MOTOR_INTERMITTENT, 4.0)) == HELD


def test_told_is_the_first_high_alarm_after_the_fault_whoever_raised_it() -> None:
    told = [
        Told(Condition.HEAD_STALLED, 1.0, "controller"),
        Told(Condition.LINE_CLOGGED, 3.0, "controller"),
        Told(Condition.RESERVE_ENERGY_USED, 5.0, "power"),
    ]
    assert left_inside.told_s(told, 0.5) == 1.0
    assert left_inside.told_s(told, 2.0) == 5.0
    assert math.isnan(left_inside.told_s(told, 6.0))
