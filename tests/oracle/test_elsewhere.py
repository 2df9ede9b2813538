"""A catheter that is not where its head is, and heads that only seem to run away.

Each run broke the bound of its hazard before there was a light barrier at the tube's mouth, a
switch whose line is watched, and a motor that is held against both sensors. Judged by the truth
alone, watched for 60 s.
"""

import math
from typing import NamedTuple

import pytest

from opensuction.kernel.vocabulary import Phase
from opensuction.safety.condition import Condition
from opensuction.safety.handling import Priority
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation.injection import injection, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.injection import SIGNS
from opensuction.simulation.injection.run_judgement import COLUMNS, Judgement
from opensuction.twin.fault.fault import Fault
from tests.quiet_patient import quiet

WATCHED_S = 60.0
ROOM = injection.make_room(WATCHED_S, names=tuple(dict.fromkeys((*SIGNS, *COLUMNS))))


class Run(NamedTuple):
    """What is played."""

    fault: Fault
    strength: float
    phase: Phase
    after_s: float
    patient: str
    approach: str
    seed: int


def judge(run: Run) -> tuple[Judgement, float]:
    """What a run came to, and when its fault came."""
    choice = CycleChoice(
        RigChoice(patient=quiet(run.patient), seed=run.seed),
        approach=run.approach,
        compensation="exact-inverse",
    )
    prepared = cycle_run.prepare(resolution.resolve(choice))
    one = Injection(run.fault, FaultInstant(run.phase, run.after_s), run.strength)
    done = injection.run(
        prepared.loop, prepared.start, (one,), after_s=WATCHED_S, seed=run.seed, room=ROOM
    )
    cap_mm = prepared.loop.controller.limits.cap_mm
    judged = run_judgement.judge(prepared.rig.machine, cap_mm, done.columns, done.faults)
    return judged, done.faults[0].at_s


def told_s(judged: Judgement, condition: Condition, from_s: float) -> float:
    """How long after an instant people were told of a condition; nan for never."""
    for one in judged.told:
        if one.condition == condition and one.at_s >= from_s:
            return one.at_s - from_s
    return math.nan


@pytest.mark.requirement("OS-R45")
@pytest.mark.parametrize(
    "run",
    [
        Run(Fault.MESSAGE_LATE, 0.02, Phase.INSERTING, 2.386, "child-10kg", "contact", 1),
        Run(Fault.READING_LATE, 0.02, Phase.INSERTING, 1.565, "adult-ards", "contact", 1),
        Run(Fault.READING_REPEATED, 0.0, Phase.BACKING_OFF, 0.237, "child-10kg", "contact", 3),
        Run(Fault.MOTOR_INTERMITTENT, 0.1, Phase.INSERTING, 0.35, "adult-icu", "contact", 1),
        Run(Fault.MOTOR_INTERMITTENT, 0.1, Phase.BACKING_OFF, 0.401, "child-10kg", "contact", 4),
        Run(Fault.HEAD_SENSORS_DRIFTING, -2.0, Phase.BACKING_OFF, 0.706, "adult-icu", "contact", 1),
        Run(Fault.HEAD_SENSORS_DRIFTING, -2.0, Phase.SUCTIONING, 0.28, "neonate", "travel", 1),
        Run(Fault.HEAD_SENSORS_DRIFTING, 2.0, Phase.INSERTING, 2.0, "adult-ards", "travel", 2),
        Run(Fault.HEAD_SENSORS_DRIFTING, -1.0, Phase.INSERTING, 1.0, "neonate", "contact", 2),
    ],
    ids=lambda run: f"{run.fault.title}-{run.patient}",
)
def test_nobody_is_left_inside_by_what_only_seems_to_run_away_or_to_be_held(run: Run) -> None:
    judged, _ = judge(run)
    assert judged.left_inside is None
    assert judged.breaches == ()


@pytest.mark.requirement("OS-R17")
@pytest.mark.parametrize("length_mm", [1.0, 20.0])
@pytest.mark.parametrize(("patient", "approach"), [("adult-icu", "travel"), ("neonate", "contact")])
def test_a_tip_that_stays_behind_is_told_as_it_parts(
    patient: str, approach: str, length_mm: float
) -> None:
    run = Run(Fault.TIP_LEFT_BEHIND, length_mm, Phase.SUCTIONING, 0.3, patient, approach, 2)
    judged, at_s = judge(run)
    assert judged.borne.piece_mm == length_mm
    assert judged.left_inside is not None
    assert judged.left_inside.unavoidable
    assert judged.left_inside.in_time
    assert told_s(judged, Condition.TIP_DETACHED, at_s) < 16.0
    assert Condition.TIP_DETACHED.row.handling.priority == Priority.HIGH
    # What is left of the catheter comes out.
    assert not judged.borne.inside_at_end


@pytest.mark.requirement("OS-R17")
@pytest.mark.parametrize("lost", [0.2, 0.6])
@pytest.mark.parametrize("patient", ["adult-icu", "neonate"])
def test_a_catheter_that_did_not_come_with_its_head_is_told_when_the_head_is_home(
    patient: str, lost: float
) -> None:
    run = Run(Fault.CLAMP_SLIPPING, lost, Phase.SUCTIONING, 0.3, patient, "travel", 2)
    judged, at_s = judge(run)
    assert told_s(judged, Condition.HEAD_SENSORS_DISAGREE, at_s) < 20.0
    if judged.left_inside is not None:
        assert judged.left_inside.unavoidable
        assert judged.left_inside.in_time


@pytest.mark.requirement("OS-R38")
@pytest.mark.parametrize("seed", [1, 3, 4, 7])
def test_a_stiff_lung_that_loses_volume_is_told_before_it_has_lost_it(seed: int) -> None:
    # Early: suction ends soon after nothing comes.
    run = Run(Fault.LUNG_VOLUME_LOST, 0.0, Phase.SUCTIONING, 0.6, "adult-ards", "travel", seed)
    judged, at_s = judge(run)
    # The first one's suction is over before the pressure is low for long.
    assert seed == 1 or told_s(judged, Condition.LUNG_VOLUME_LOST, at_s) < 5.0
    assert judged.harm == ()
    assert judged.borne.lung_volume_loss_ml < 600.0


@pytest.mark.requirement("OS-R35")
@pytest.mark.parametrize("patient", ["adult-icu", "adult-ards"])
def test_a_head_that_coasts_past_its_home_is_out_and_nobody_is_told_otherwise(patient: str) -> None:
    """A clogged line keeps its suction on the way out, and no trip lets the head go in again."""
    run = Run(Fault.LINE_CLOGGED, 1.0, Phase.SUCTIONING, 0.5, patient, "travel", 1)
    judged, at_s = judge(run)
    assert not math.isnan(told_s(judged, Condition.LINE_CLOGGED, at_s))
    assert math.isnan(told_s(judged, Condition.WITHDRAWAL_TIME, at_s))
    assert judged.left_inside is None
