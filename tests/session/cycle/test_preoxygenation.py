"""Pre-oxygenation before a cycle of the twin: given or skipped, and what it is worth."""

import numpy as np
import pytest

from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import START
from opensuction.result.cycle_result import OxygenRecord
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.trace import Columns

EXACT = CycleChoice(compensation="exact-inverse")


def played(choice: CycleChoice) -> tuple[Prepared, Columns]:
    ready = cycle_run.oxygenate(cycle_run.prepare(resolution.resolve(choice)))
    return ready, cycle_run.played(ready, ready.start, START)[1]


def test_what_was_confirmed_was_given_and_helps() -> None:
    given, with_oxygen = played(EXACT)
    _, without = played(EXACT._replace(preoxygenation="skipped"))
    assert resolution.on_record(with_oxygen) == OxygenRecord(True, "confirmed")
    assert resolution.on_record(without) == OxygenRecord(True, "skipped")
    assert with_oxygen["time_s"][0] == without["time_s"][0] == 0.0
    lowest = [np.min(columns["truth.spo2_percent"]) for columns in (with_oxygen, without)]
    assert lowest[0] > lowest[1] + 1.0
    # Only for this run: the patient's own settings are untouched.
    assert given.rig.machine.patient.ventilator.oxygen_ratio < 0.9


def test_a_prepared_cycle_that_is_simply_played_was_skipped() -> None:
    ready = cycle_run.prepare(resolution.resolve(EXACT))
    columns = cycle_run.play(ready)
    assert resolution.on_record(columns).state == "skipped"


def test_a_neonate_and_the_bench_are_given_none() -> None:
    neonate = EXACT._replace(rig=RigChoice(patient="neonate"))
    ready, columns = played(neonate)
    assert resolution.on_record(columns) == OxygenRecord(False, "not-required")
    plain = cycle_run.prepare(resolution.resolve(neonate))
    assert ready.loop.machine == plain.loop.machine


@pytest.mark.parametrize(
    ("rig", "answer", "words"),
    [
        (RigChoice(patient="neonate"), "confirmed", "nobody asks"),
        (RigChoice("bench"), "skipped", "nobody asks"),
        (RigChoice(), "perhaps", "confirmed, skipped"),
    ],
)
def test_an_answer_that_nobody_asked_for_is_refused(
    rig: RigChoice, answer: str, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        resolution.resolve(CycleChoice(rig, preoxygenation=answer))
