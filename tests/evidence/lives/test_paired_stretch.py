"""Stretches of a controller's and the twin's ticks: the same steps as one after the other."""

import pytest

from opensuction.evidence.lives import life, paired_stretch, simulated_computer
from opensuction.evidence.lives.life_fault import CONTROL, RECORDER, Kind, LifeFault
from opensuction.evidence.lives.life_record import Life, LifeResult
from opensuction.kernel.vocabulary import Phase

INSERTING, SUCTIONING = Phase.INSERTING, Phase.SUCTIONING
LIVES = {
    "a controller that stands still for a moment, and dies": (
        LifeFault(Kind.FREEZE, CONTROL, SUCTIONING, 0.0, 0.012),
        LifeFault(Kind.FREEZE, CONTROL, INSERTING, 0.03, 0.4),
        LifeFault(Kind.KILL, CONTROL, Phase.WITHDRAWING, 0.05, 0.0),
    ),
    "a host that stands still while mail is lost": (
        LifeFault(Kind.STANDSTILL, "", None, 7.0, 2.5),
        LifeFault(Kind.MAIL, "", None, 2.0, 6.0),
        LifeFault(Kind.KILL, RECORDER, Phase.WITHDRAWING, 0.01, 0.0),
    ),
}


SLOW_AND_STOPPED = (
    LifeFault(Kind.SLOW, "", INSERTING, 0.0, 1.5),
    LifeFault(Kind.STOP, "", INSERTING, 0.09, 0.0),
)


def _one_by_one(monkeypatch: pytest.MonkeyPatch, drawn: Life) -> LifeResult:
    """The life with each step done by its own process."""
    with monkeypatch.context() as patched:
        patched.setattr(simulated_computer, "PairedStretches", lambda _: None)
        return life.play(drawn)


@pytest.mark.parametrize(
    "faults",
    [
        pytest.param(faults, id=what, marks=pytest.mark.soak if "mail" in what else ())
        for what, faults in LIVES.items()
    ],
)
def test_a_life_is_the_same_with_each_step_done_by_itself(
    faults: tuple[LifeFault, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = Life(5, 2, faults)
    found, expected = life.play(drawn), _one_by_one(monkeypatch, drawn)
    assert found.violations == ()
    assert found == expected


def test_most_steps_of_a_slow_computer_are_done_in_stretches_and_are_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where they were few nothing would have been shown of them. A person stops the machine."""
    drawn, lengths = Life(5, 2, SLOW_AND_STOPPED), []
    pass_by = simulated_computer.SimulatedComputer.pass_by

    def count(self: simulated_computer.SimulatedComputer, at_ns: object, pids: object) -> None:
        lengths.append(len(at_ns))  # type: ignore[arg-type]
        pass_by(self, at_ns, pids)  # type: ignore[arg-type]

    monkeypatch.setattr(simulated_computer.SimulatedComputer, "pass_by", count)
    found = life.play(drawn)
    assert sum(lengths) > 0.8 * found.steps
    assert max(lengths) <= paired_stretch.MOST
    assert found.violations == ()
    assert found == _one_by_one(monkeypatch, drawn)


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(20))
def test_lives_of_all_faults_are_the_same(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = life.draw(710_000 + seed)
    assert life.play(drawn) == _one_by_one(monkeypatch, drawn)
