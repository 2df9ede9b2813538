"""A day of cycles: what is produced must be somewhere, and the controller's own rules hold."""

from functools import cache

import numpy as np
import pytest

from opensuction.controller.controller import with_upkeep
from opensuction.kernel.errors import InputError
from opensuction.procedure.cycle.interlocks import LIFE_S
from opensuction.safety.condition import Condition
from opensuction.session.choice import CycleChoice, DayChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.day import day_fault, day_run, day_summary
from opensuction.session.day.day_run import Day
from tests.quiet_patient import quiet

EVERY_MIN = 60.0
EVERY_S = 60.0 * EVERY_MIN
CYCLES = 8
USED_S = LIFE_S - 6.0 * EVERY_S  # its life is over six intervals later


@cache
def day() -> Day:
    # Nobody coughs anything up.
    rig = RigChoice(patient=quiet("adult-icu"))
    resolved = resolution.resolve(CycleChoice(rig, compensation="exact-inverse"))
    begun = cycle_run.prepare(resolved)
    controller = begun.start.controller
    used = controller.core.upkeep._replace(catheter_age_s=USED_S)
    old = begun._replace(start=begun.start._replace(controller=with_upkeep(controller, used)))
    return day_run.play(old, DayChoice(CYCLES, EVERY_MIN), lambda *_: None)


def test_every_cycle_is_completed_and_starts_on_the_clock() -> None:
    starts = np.array([cycle.start_s for cycle in day().cycles])
    assert all(cycle.outcome.completed for cycle in day().cycles)
    assert len(starts) == CYCLES
    # A person who changes the catheter starts the cycle half a second before it was due.
    assert np.diff(starts) == pytest.approx(EVERY_S, abs=1.0)


def test_secretions_are_conserved_over_the_day() -> None:
    """Trachea before + produced = trachea after + removed, cycle by cycle."""
    found = day()
    rate = found.last.rig.machine.patient.secretion.production_ml_per_h / 3600.0
    span_s = found.samples.time_s[-1] - found.samples.time_s[0]
    assert found.produced_ml == pytest.approx(rate * span_s, rel=1e-3)
    for before, after in zip(found.cycles[:-1], found.cycles[1:], strict=True):
        left = before.secretion_before_ml - before.outcome.removed_ml
        gathered = after.secretion_before_ml - left
        assert gathered == pytest.approx(rate * EVERY_S, rel=0.01)


def test_the_catheter_is_changed_before_its_life_ends() -> None:
    changed = [cycle.number for cycle in day().cycles if cycle.catheter_changed]
    assert changed == [7]  # it would be 24 h old within the seventh cycle
    assert max(cycle.catheter_age_s for cycle in day().cycles) <= LIFE_S


def test_a_person_looks_at_the_patient_after_every_third_pass_and_answers_before_each() -> None:
    found = day()
    assert [cycle.number for cycle in found.cycles if cycle.assessed] == [4, 7]
    assert {cycle.preoxygenation for cycle in found.cycles} == {"confirmed"}
    told = {alarm.condition for cycle in found.cycles for alarm in cycle.outcome.alarms}
    assert told == {Condition.CATHETER_LIFE_ENDING}  # of the catheter that is changed
    said = " ".join(day_summary.notes(found))
    assert "looked at the patient 2 times" in said
    assert "confirmed by a person before 8 cycles" in said
    assert day_summary.summary(found).assessments == 2


def test_oxygen_is_given_before_each_cycle_and_taken_back_after_it() -> None:
    samples, second = day().samples, day().cycles[1]
    before = samples.time_s < second.start_s - resolution.GIVEN_S - day_run.WAKE_S
    at_rest = (samples.time_s > 1800.0) & before
    resting = np.median(samples.spo2_percent[at_rest])
    during = (samples.time_s > second.start_s) & (samples.time_s < second.start_s + 60.0)
    assert samples.spo2_percent[during].min() > resting + 1.0
    assert np.ptp(samples.spo2_percent[at_rest]) < 1.0


def test_the_last_cycle_is_reported_from_its_own_start() -> None:
    found = day()
    assert found.columns["time_s"][0] == 0.0
    figures = cycle_run.figures(found.last, found.columns)
    assert figures.removed_ml == pytest.approx(found.cycles[-1].outcome.removed_ml)
    assert 0.0 < figures.removed_percent <= 100.0


def test_samples_cover_the_day_in_order() -> None:
    samples = day().samples
    assert np.all(np.diff(samples.time_s) >= 0.0)
    # The presses of the person who comes before a cycle are ticks on top of a whole minute.
    assert np.max(np.diff(samples.time_s)) <= day_run.SAMPLE_S + 0.01
    assert np.all(samples.secretion_ml >= 0.0)
    assert 60.0 < np.min(samples.spo2_percent) <= 100.0


def test_notes_say_what_a_person_should_know() -> None:
    said = day_summary.notes(day())
    assert any("as needed" in note for note in said)
    grew = day().left_ml > day().cycles[0].secretion_before_ml
    assert any("gather faster" in note for note in said) == grew


@pytest.mark.parametrize(
    ("repeat", "every_min", "bench", "words"),
    [
        (3, None, False, "needs --every"),
        (1, 30.0, False, "says nothing without --repeat"),
        (3, 5.0, False, "not at least 15 min"),
        (3, float("nan"), False, "not at least 15 min"),
        (3, 1441.0, False, "--every 1441: should be at most 1440 min"),
        (3, float("inf"), False, "--every inf: should be at most 1440 min"),
        (3, 30.0, True, "the bench has none"),
        (501, 30.0, False, "at most 500"),
    ],
)
def test_what_is_no_day_is_refused(
    repeat: int, every_min: float | None, bench: bool, words: str
) -> None:
    resolved = resolution.resolve(CycleChoice(RigChoice("bench" if bench else "clinical")))
    with pytest.raises(InputError, match=words):
        day_fault.check(DayChoice(repeat, every_min), resolved)
