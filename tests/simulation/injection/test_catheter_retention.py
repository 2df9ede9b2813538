"""A catheter that stays inside: unavoidable by physics alone, and then told."""

import math

import pytest

from opensuction.safety.condition import Condition
from opensuction.simulation import rig as rigs
from opensuction.simulation.injection import run_judgement
from opensuction.simulation.injection.fault_instant import AT_START, Injection
from opensuction.simulation.injection.run_judgement import (
    HELD,
    LOOSE,
    PARTED,
    POWERLESS,
    SLIPPED,
    Unavoidable,
)
from opensuction.simulation.outcome import Annunciation
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

MACHINE = rigs.rig("clinical", 1, patient="child-10kg").machine


def why(*faults: tuple[Fault, float]) -> Unavoidable | None:
    came = [Injection(fault, AT_START, strength) for fault, strength in faults]
    return run_judgement.find_unavoidable(MACHINE, came)


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


def test_a_motor_that_is_gone_for_as_long_as_a_withdrawal_takes_is_lost() -> None:
    assert why((Fault.MOTOR_INTERMITTENT, 3.9)) is None
    assert why((Fault.MOTOR_INTERMITTENT, 4.0)) == HELD


def test_told_is_the_first_high_alarm_after_the_fault_whoever_raised_it() -> None:
    told = [
        Annunciation(Condition.HEAD_STALLED, 1.0, "controller"),
        Annunciation(Condition.LINE_CLOGGED, 3.0, "controller"),
        Annunciation(Condition.RESERVE_ENERGY_USED, 5.0, "power"),
    ]
    assert run_judgement.told_s(told, 0.5) == 1.0
    assert run_judgement.told_s(told, 2.0) == 5.0
    assert math.isnan(run_judgement.told_s(told, 6.0))
