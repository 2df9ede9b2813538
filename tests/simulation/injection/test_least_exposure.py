"""The least that a fault of the drive leaves a patient to bear, and what it excuses."""

from functools import cache

import numpy as np
import pytest

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import JUDGED, Played
from opensuction.evidence.campaign.sound_machine import Kind, SoundMachine
from opensuction.evidence.safety_case.hazard_case import COMPENSATION
from opensuction.oracle import exposure
from opensuction.oracle.exposure import PatientExposure
from opensuction.simulation.injection import least_exposure, run_judgement
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.run_judgement import Judgement
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault

KIND = Kind("child-10kg", "contact")
ROOM = played_cycle.make_room(JUDGED)


@cache
def sound() -> SoundMachine:
    return sound_machine.play(sound_machine.prepare(KIND, 2, COMPENSATION), ROOM)


def play(fault: Fault, at_s: float, strength: float) -> tuple[Played, PatientExposure]:
    one = Injection(fault, FaultInstant(None, at_s), strength)
    played = played_cycle.play_faulty(sound(), (one,), 2, ROOM)
    return played, exposure.measure(sound().prepared.rig.machine, played.run.columns)


def judge(played: Played, columns: Columns) -> Judgement:
    prepared = played.prepared
    machine, cap_mm = prepared.rig.machine, prepared.loop.controller.limits.cap_mm
    judged = run_judgement.judge(machine, cap_mm, columns, played.run.faults)
    return run_judgement.spare(judged, machine, played.run._replace(columns=columns))


@pytest.mark.parametrize(
    ("at_s", "strength"), [(7.9, 3.98), (7.9, 4.0), (7.92, 4.02), (7.95, 4.02), (8.035, 4.04)]
)
def test_a_drive_that_hardly_pulls_is_as_fast_as_any_could_be(at_s: float, strength: float) -> None:
    """A jam as strong as the motor, as the tip comes to the carina: 3.04 to 4.9 s on it, of 3."""
    played, borne = play(Fault.CATHETER_JAMMED, at_s, strength)
    judged = played.judge()
    assert borne.contact_s > 3.0
    assert "contact-time" in {one.name for one in judged.harm}
    assert judged.breaches == ()
    (least,) = judged.unavoidable
    assert (least.name, least.limit) == ("contact-time", 3.0)
    assert borne.contact_s == pytest.approx(least.worst, abs=0.002)


def test_what_another_withdrawal_could_have_spared_is_a_breach() -> None:
    """The same catheter held by less, and a contact of 3.2 s that nothing made so long."""
    played, borne = play(Fault.CATHETER_JAMMED, 8.035, 3.9)
    assert borne.contact_s < 3.0
    assert played.judge().harm == ()
    columns = dict(played.run.columns)
    touched = np.array(columns["truth.contact_n"])
    touched[8_100:11_300] = 0.02
    judged = judge(played, {**columns, "truth.contact_n": touched})
    assert [one.name for one in judged.breaches] == ["contact-time"]
    assert judged.unavoidable == ()


def test_nothing_is_excused_of_which_nobody_was_told() -> None:
    played, _ = play(Fault.CATHETER_JAMMED, 8.035, 4.04)
    silent = np.zeros_like(played.run.columns["annunciator.said"])
    judged = judge(played, {**played.run.columns, "annunciator.said": silent})
    assert [one.name for one in judged.breaches] == ["contact-time"]


def test_the_least_time_in_the_airway_is_that_of_the_whole_voltage() -> None:
    """A weak motor while suction goes on: the run waits for its end, the least does not."""
    begin_s, end_s = sound().healthy.spans["suctioning"]
    at_s = round(0.5 * (begin_s + end_s), 3)
    played, borne = play(Fault.MOTOR_WEAK, at_s, 0.5)
    machine = sound().prepared.rig.machine
    least = least_exposure.find(machine, played.run)
    assert least is not None
    inside = exposure.find_inside(machine, played.run.columns["truth.tip_mm"])
    before_s = float(inside[: round(at_s * 1000.0)].sum()) / 1000.0
    assert before_s < least.in_airway_s < borne.in_airway_s
    # Nothing of the machine pulls a catheter out that is held by more than the motor's force.
    held, _ = play(Fault.CATHETER_JAMMED, at_s, 50.0)
    stays = least_exposure.find(machine, held.run)
    assert stays is not None
    assert stays.in_airway_s == float("inf")


def test_faults_that_pass_or_that_are_not_of_the_machine_have_no_least() -> None:
    machine = sound().prepared.rig.machine
    for fault, strength in ((Fault.MOTOR_INTERMITTENT, 0.5), (Fault.ENCODER_FROZEN, 0.0)):
        played, _ = play(fault, 8.0, strength)
        assert least_exposure.find(machine, played.run) is None
