"""Faults planted in the software itself, and lives that find them."""

import pytest

from opensuction.evidence.lives import life, life_fault
from opensuction.evidence.lives.life import Life
from opensuction.evidence.lives.life_fault import Kind, LifeFault
from opensuction.kernel.vocabulary import Phase
from tests.evidence.lives.planted import PLANTED, PlantedFault

BY_NAME = {one.name: one for one in PLANTED}
MOST_LIVES = 60
"""Lives that a planted fault is looked for in, by the seeds from 0 on."""
OPEN = {"finds-nobody", "no-keys", "no-mark"}
"""Not found yet, and looked for all the same."""
QUIET = LifeFault(Kind.SLOW, "", None, 0.0, 0.001)
KILL_CONTROL = LifeFault(Kind.KILL, life_fault.CONTROL, Phase.SUCTIONING, 0.05, 0.0)
KILL_EARLY = LifeFault(Kind.KILL, life_fault.CONTROL, Phase.PRELOADING, 0.02, 0.0)
KILL_RECORDER = LifeFault(Kind.KILL, life_fault.RECORDER, Phase.INSERTING, 0.05, 0.0)
KILL_ALL = LifeFault(Kind.KILL, life_fault.ALL, Phase.INSERTING, 0.05, 0.0)
FREEZE_CONTROL = LifeFault(Kind.FREEZE, life_fault.CONTROL, Phase.INSERTING, 0.05, 4.0)
FREEZE_BRIEFLY = LifeFault(Kind.FREEZE, life_fault.CONTROL, Phase.INSERTING, 0.05, 0.01)
QUICK = {
    "hung-never": ("hang", FREEZE_CONTROL),
    "misses-nobody": ("told", KILL_RECORDER),
    "waits-long": ("told", KILL_CONTROL),
    "uncounted-ticks": ("ticks", FREEZE_BRIEFLY),
    "forgets-the-phase": ("memory", KILL_EARLY),
    "no-end": ("record", KILL_CONTROL),
    "leaves-the-dead": ("rows", KILL_ALL),
    "no-notes": ("kept", KILL_RECORDER),
    "answers-nobody": ("press", QUIET),
    "no-footer": ("recording", QUIET),
}
"""Faults with a life that finds each, and the invariant that it breaks."""


def _broken(*faults: LifeFault) -> set[str]:
    return {one.invariant for one in life.play(Life(1, 3, faults)).violations}


@pytest.mark.parametrize("name", QUICK)
def test_a_planted_fault_breaks_its_invariant(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    invariant, fault = QUICK[name]
    BY_NAME[name].plant(monkeypatch)
    assert invariant in _broken(fault)


@pytest.mark.parametrize("fault", sorted({fault for _, fault in QUICK.values()}, key=repr))
def test_the_same_lives_break_nothing_without_it(fault: LifeFault) -> None:
    assert _broken(fault) == set()


@pytest.mark.soak
@pytest.mark.parametrize("planted", PLANTED, ids=lambda one: one.name)
def test_every_planted_fault_is_found_by_drawn_lives(
    planted: PlantedFault, monkeypatch: pytest.MonkeyPatch
) -> None:
    planted.plant(monkeypatch)
    found = any(life.play(life.draw(seed)).violations for seed in range(MOST_LIVES))
    assert found or planted.name in OPEN
