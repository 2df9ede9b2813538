"""Faults planted in the software itself, and lives that find them."""

import pytest

from opensuction.evidence.lives import life, life_fault
from opensuction.evidence.lives.life_fault import Kind, LifeFault
from opensuction.kernel.vocabulary import Phase
from tests.evidence.lives.chosen_life import broken, play
from tests.evidence.lives.planted import PLANTED, PlantedFault

BY_NAME = {one.name: one for one in PLANTED}
MOST_LIVES = 2000
"""Lives that a planted fault is looked for in, by the seeds from 0 on."""
SEEDS = range(1, 5)
"""Of lives with chosen faults, one after the other until one breaks the invariant."""
OPEN = {"finds-nobody", "no-mark"}
"""Not found yet, and looked for all the same."""
QUIET = (LifeFault(Kind.SLOW, "", None, 0.0, 0.001),)
KILL_RECORDER = (LifeFault(Kind.KILL, life_fault.RECORDER, Phase.CHECKING, 2.0, 0.0),)
FREEZE_CONTROL = (LifeFault(Kind.FREEZE, life_fault.CONTROL, Phase.CHECKING, 0.05, 4.0),)
SHORT = (
    LifeFault(Kind.FREEZE, life_fault.CONTROL, Phase.CHECKING, 0.05, 0.01),
    LifeFault(Kind.KILL, life_fault.ALL, Phase.PRELOADING, 0.035, 0.0),
)
"""A cycle that is over before the catheter goes in."""
QUICK = {
    "hung-never": ("hang", FREEZE_CONTROL),
    "misses-nobody": ("told", KILL_RECORDER),
    "waits-long": ("told", SHORT),
    "uncounted-ticks": ("ticks", SHORT),
    "forgets-the-phase": ("memory", SHORT),
    "no-end": ("record", SHORT),
    "leaves-the-dead": ("rows", SHORT),
    "no-notes": ("kept", SHORT),
    "answers-nobody": ("press", QUIET),
    "no-footer": ("recording", SHORT),
}
"""Faults with the faults of a life that finds each, and the invariant that it breaks."""

FURTHER = {
    "misses-nobody": pytest.mark.sweep,
    "no-end": pytest.mark.soak,
    "no-notes": pytest.mark.soak,
}
"""Another one breaks the same invariant in `make test`, here or in `test_lives` and its likes."""


@pytest.mark.parametrize("name", [pytest.param(one, marks=FURTHER.get(one, ())) for one in QUICK])
def test_a_planted_fault_breaks_its_invariant(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    invariant, faults = QUICK[name]
    monkeypatch.setattr(life, "LONGEST_S", 20.0)  # some never settle
    BY_NAME[name].plant(monkeypatch)
    # Which process is the first to be there again is drawn by the seed.
    assert any(invariant in broken(play(*faults, seed=seed)) for seed in SEEDS)


@pytest.mark.parametrize(
    "faults",
    [
        pytest.param(KILL_RECORDER, id="recorder", marks=pytest.mark.sweep),
        pytest.param(FREEZE_CONTROL, id="control"),
        pytest.param(SHORT, id="short"),
    ],
)
def test_the_same_lives_break_nothing_without_it(faults: tuple[LifeFault, ...]) -> None:
    """`test_lives` says so of the quiet one."""
    assert broken(play(*faults)) == set()


@pytest.mark.soak
@pytest.mark.parametrize("planted", PLANTED, ids=lambda one: one.name)
def test_every_planted_fault_is_found_by_drawn_lives(
    planted: PlantedFault, monkeypatch: pytest.MonkeyPatch
) -> None:
    planted.plant(monkeypatch)
    found = any(life.play(life.draw(seed)).violations for seed in range(MOST_LIVES))
    assert found or planted.name in OPEN
