"""Whoever dies in a cycle: the tip comes out, people are told, and what was kept is not lost."""

from collections.abc import Iterator
from functools import cache

import pytest

from opensuction.kernel.vocabulary import Phase
from tests.runtime.kills import (
    AT_ITS_BEGINNING,
    LOCKS,
    SUCTIONS_S,
    VICTIMS,
    SimulatedWard,
    Ward,
    kept_up,
    one,
)
from tests.runtime.room import INSIDE_MM
from tests.runtime.simulated_room import simulated

PHASES = (
    *(Phase.PRELOADING, Phase.INSERTING, Phase.SUCTIONING),
    *(Phase.WITHDRAWING, Phase.CLOSING, Phase.PARKED),
)
"""With whose beginning somebody dies: the first tick of each is searched for."""
NEAR_S = (-0.001, 0.0005, 0.002, 0.02)
"""Before or after it, by turns."""
TICK_S = 0.001
DEATHS = [
    pytest.param(
        phase,
        victim,
        # Half of them stay: each victim, each phase, and whoever hangs.
        marks=() if (i // 2 + j) % 2 == 0 else pytest.mark.soak,
        id=f"{phase.name.lower()}-{victim}",
    )
    for i, phase in enumerate(PHASES)
    for j, victim in enumerate(VICTIMS)
]


@pytest.fixture
def ward() -> Iterator[Ward]:
    with (
        simulated(begins=False) as room,
        kept_up(SimulatedWard(room, room.folder / "recordings")) as made,
    ):
        yield made


@cache
def edges_s() -> dict[Phase, float]:
    """When each phase begins in a cycle in which nobody dies, after the start's button."""
    found: dict[Phase, float] = {}
    with (
        simulated(begins=False) as room,
        kept_up(SimulatedWard(room, room.folder / "recordings")) as ward,
    ):
        ward.witness.begin()
        ward.begin_cycle()
        begun_s = room.now_s()
        while Phase.PARKED not in found:
            found.setdefault(room.phase(), room.now_s() - begun_s)
            room.rest(TICK_S)
    return found


@pytest.mark.parametrize("victim", VICTIMS)
def test_whoever_dies_with_the_tip_inside_it_comes_out_and_the_record_has_its_end(
    ward: Ward, victim: str
) -> None:
    fate = one(ward, victim, SUCTIONS_S)
    assert not fate.wrong, fate
    assert fate.depth_mm > INSIDE_MM


@pytest.mark.parametrize(("victim", "at_s", "hung"), AT_ITS_BEGINNING)
def test_whoever_dies_as_a_cycle_begins_leaves_it_on_record(
    ward: Ward, victim: str, at_s: float, hung: str | None
) -> None:
    fate = one(ward, victim, at_s, hung)
    assert not fate.wrong, fate


@pytest.mark.parametrize(("phase", "victim"), DEATHS)
def test_whoever_dies_or_hangs_as_a_phase_begins_leaves_the_tip_outside(
    ward: Ward, phase: Phase, victim: str
) -> None:
    """In half of them another one hangs."""
    number = PHASES.index(phase) + list(VICTIMS).index(victim)
    able = [name for name in LOCKS if LOCKS[name] not in VICTIMS[victim]]
    hung = able[number % len(able)] if able and PHASES.index(phase) % 2 else None
    at_s = edges_s()[phase] + NEAR_S[number % len(NEAR_S)]
    fate = one(ward, victim, at_s, hung)
    assert not fate.wrong, fate
    assert (fate.phase == phase.name.lower()) == (NEAR_S[number % len(NEAR_S)] > 0.0), fate
