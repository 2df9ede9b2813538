"""A trial as a script runs it: the command's figures, typed."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

import opensuction as osn
from opensuction.evidence import worker_pool
from opensuction.result.trial_result import Trial
from tests.library.test_fit import refusal


def play_here(play: Callable[[Any], Any], tasks: Sequence[Any], _: int, tell: Any, __: Any) -> None:
    """As `worker_pool.spread` does, without a process."""
    for number, task in enumerate(tasks):
        tell(number, play(task))


def test_a_trial_gives_what_its_cycles_came_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker_pool, "spread", play_here)
    found = osn.trial(2, faults="none", cohort="neonate", seed=3, workers=1)
    assert found.is_good
    assert (found.result.cycles, found.result.complete, found.result.workers) == (2, True, 1)
    assert found.result.trial == Trial("none", "neonate", 3)
    assert found.summary["counted"] == {"none": 2, "single": 0, "double": 0}
    assert repr(found) == (
        "TrialRun(2 cycles, faults none, 0 bounds broken, 0 false alarms, 0 left inside)"
    )
    spread = found.endpoints["neonate"].suction_s
    assert spread is not None
    assert 2.0 < spread.p5 < spread.median < spread.p95 < 5.0
    found.report(tmp_path / "trial.md")
    assert "neonate" in (tmp_path / "trial.md").read_text("utf-8")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"cycles": 0}, "cycles 0: should be 1 or more"),
        ({"workers": 0}, "workers 0: should be 1 or more"),
        ({"seed": -1}, "seed -1: should be 0 to"),
        ({"faults": "triple"}, "faults 'triple'"),
        ({"cohort": "giants"}, "cohort 'giants'"),
        ({"preoxygenation": "maybe"}, "preoxygenation 'maybe'"),
        ({"compensation": "magic"}, "magic"),
    ],
)
def test_what_cannot_be_a_trial_is_refused_in_one_line(given: dict[str, Any], words: str) -> None:
    said = refusal(lambda: osn.trial(**({"cycles": 2} | given)))
    assert words in said
    assert "--" not in said
