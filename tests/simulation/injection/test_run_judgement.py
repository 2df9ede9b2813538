"""Runs with faults before their judge: the patients of the audit, by the truth alone."""

from functools import cache

import pytest

from opensuction.kernel.vocabulary import Phase
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.injection import injection, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.run_judgement import Judgement
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

WATCHED_S = 60.0


@cache
def prepared(patient: str) -> Prepared:
    choice = CycleChoice(RigChoice(patient=patient, seed=3), compensation="exact-inverse")
    return cycle_run.prepare(resolution.resolve(choice))


def judged(
    fault: Fault, phase: Phase, after_s: float, patient: str = "adult-icu", within_s: float = 1.0
) -> Judgement:
    one = Injection(fault, FaultInstant(phase, after_s), ROWS[fault].default_strength)
    made = prepared(patient)
    run = injection.run(made.loop, made.start, [one], after_s=WATCHED_S)
    cap_mm = made.loop.controller.limits.cap_mm
    return run_judgement.judge(made.rig.machine, cap_mm, run.columns, run.faults, within_s)


@pytest.mark.parametrize("patient", ["adult-icu", "neonate"])
def test_power_that_is_lost_without_reserve_leaves_the_catheter_inside_and_is_told(
    patient: str,
) -> None:
    """Unavoidable, told by the power supply at once; what stays broken is no breach."""
    found = judged(Fault.POWER_LOST_WITHOUT_RESERVE, Phase.SUCTIONING, 1.0, patient)
    assert found.left_inside is not None
    assert found.left_inside.unavoidable
    assert found.left_inside.told_s < 0.1
    assert found.left_inside.in_time
    assert {"left-inside", "airway-time"} <= {one.name for one in found.harm}
    assert found.borne.in_airway_s > WATCHED_S
    assert found.breaches == ()
    assert found.told[-1].by in ("power", "drives")


def test_what_is_unavoidable_is_a_breach_where_nobody_is_told_in_time() -> None:
    # The head stands for longer than that, and nobody can tell a motor at rest from a stalled one.
    found = judged(Fault.MOTOR_STALLED, Phase.OPENING, 0.05, within_s=0.5)
    assert found.left_inside is not None
    assert found.left_inside.told_s > 0.5
    assert [one.name for one in found.breaches] == ["left-inside"]


def test_a_fault_that_nothing_excuses_leaves_nobody_inside() -> None:
    found = judged(Fault.POWER_LOST, Phase.SUCTIONING, 1.0)
    assert found.left_inside is None
    assert found.breaches == found.harm == ()


def test_an_open_circuit_is_a_harm_and_none_of_the_machines_doing() -> None:
    found = judged(Fault.CIRCUIT_DISCONNECTED, Phase.INSERTING, 1.0)
    assert "airway-pressure" in {one.name for one in found.harm}
    assert found.breaches == ()
