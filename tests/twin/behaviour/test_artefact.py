"""The oximeter errs: too low, frozen, missing; and what is true stays as it is."""

import numpy as np
import pytest

from opensuction.kernel import random_stream
from opensuction.kernel.interface import NO_MONITOR
from opensuction.twin.behaviour import behaviour, spontaneous_event
from opensuction.twin.behaviour.behaviour import Artefact, ArtefactState
from tests.settled import settled
from tests.twin.behaviour import bed

OFTEN = Artefact(per_s=0.01, cough_ratio=20.0)
SHOWN = NO_MONITOR._replace(connected=True, spo2_percent=96.0, spo2_valid=True)


step_artefact = settled(behaviour.step_artefact)


def begun(since_s: float, seconds: float) -> list[ArtefactState]:
    """Each artefact as it begins, the oximeter showing 94 %."""
    state, found = behaviour.clear(random_stream.stream(2, 9)), []
    for _ in range(round(seconds / 0.1)):
        before = state.left_s
        state = step_artefact(OFTEN, state, since_s, 94.0, 0.1)
        if state.left_s > before:
            found.append(state)
    return found


def test_artefacts_of_each_kind_come_and_last_some_seconds() -> None:
    found = begun(spontaneous_event.NEVER_S, 40_000.0)
    assert len(found) == pytest.approx(40_000 / 107, abs=80)
    assert min(one.left_s for one in found) >= 2.0
    assert 11.5 < max(one.left_s for one in found) <= 12.0
    shown = [behaviour.distort(one, SHOWN) for one in found]
    missing = [one for one in shown if not one.spo2_valid]
    frozen = [one for one in shown if one.spo2_valid and one.spo2_percent == 94.0]
    low = [one.spo2_percent for one in shown if one.spo2_valid and one.spo2_percent < 94.0]
    assert len(missing) == pytest.approx(0.25 * len(found), rel=0.3)
    assert len(frozen) == pytest.approx(0.25 * len(found), rel=0.3)
    assert 81.0 <= min(low) < 82.0


def test_a_cough_makes_them_frequent() -> None:
    calm, coughing = begun(spontaneous_event.NEVER_S, 4000.0), begun(1.0, 4000.0)
    assert len(coughing) > 5 * len(calm)


def test_one_that_is_over_and_one_of_a_probe_that_is_off_change_nothing() -> None:
    over = begun(spontaneous_event.NEVER_S, 4000.0)[0]._replace(left_s=0.0)
    assert behaviour.distort(over, SHOWN) == SHOWN
    off = SHOWN._replace(spo2_percent=0.0, spo2_valid=False)
    for one in begun(spontaneous_event.NEVER_S, 4000.0):
        assert behaviour.distort(one, off) == off


def test_the_monitor_errs_and_the_truth_does_not() -> None:
    person = bed.lively()
    often = person.behaviour.artefact._replace(per_s=0.5)
    person = person._replace(behaviour=person.behaviour._replace(artefact=often))
    _, seen = bed.watch(bed.bed(person), 600.0)
    assert seen["spo2_percent"].min() > 94.0
    shown, valid = seen["shown_percent"], seen["shown"] == 1.0
    assert shown[valid].min() < 90.0
    assert 5 < bed.count_starts(~valid) < 30
    assert np.all(shown[~valid] == 0.0)
