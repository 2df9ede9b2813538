"""Whoever dies in a cycle in real time: the tip comes out, people are told, the record is whole."""

import itertools
import json
import random
from collections.abc import Callable, Iterator

import pytest

from tests.runtime.kills import (
    AT_ITS_BEGINNING,
    LOCKS,
    SUCTIONS_S,
    VICTIMS,
    Death,
    Ward,
    kept_up,
    one,
)
from tests.runtime.machine_room import running
from tests.runtime.room import INSIDE_MM

pytestmark = pytest.mark.real_time

CYCLE_S = 11.4
"""How long the neonate's cycle takes: the kill comes at any instant of it."""
EDGES_S = (0.0, 3.6, 4.2, 6.25, 7.0, 8.65, 10.6, 11.1)
"""About where its phases begin, and where it ends, after the start's button [computed]."""
EDGE_S = 0.1
"""A death at an edge is this much before it at most, or after."""


def deaths(count: int, seed: int) -> list[Death]:
    """So many, of each in turn; four by turns at any instant of a cycle and at an edge of a phase.

    In half of them another one hangs. Where all die nobody is left to hang: so it is seven of ten
    of the others.
    """
    chance = random.Random(seed)
    victims = list(itertools.islice(itertools.cycle(VICTIMS), count))
    found = []
    for number, victim in enumerate(victims):
        able = [name for name in LOCKS if LOCKS[name] not in VICTIMS[victim]]
        hangs = bool(able) and chance.random() < 0.7
        at_s = chance.uniform(0.0, CYCLE_S)
        if number // len(VICTIMS) % 2:
            at_s = max(0.0, chance.choice(EDGES_S) + chance.uniform(-EDGE_S, EDGE_S))
        found.append(Death(victim, round(at_s, 3), chance.choice(able) if hangs else None))
    return found


@pytest.fixture(scope="module")
def ward() -> Iterator[Ward]:
    with (
        running(begins=False) as room,
        kept_up(Ward(room, room.folder / "recordings")) as made,
    ):
        yield made


@pytest.mark.parametrize(
    "victim",
    [
        "control",
        *(pytest.param(one, marks=pytest.mark.soak) for one in ("recorder", "supervisor", "all")),
    ],
)
def test_whoever_dies_with_the_tip_inside_it_comes_out_and_the_record_has_its_end(
    ward: Ward, victim: str
) -> None:
    fate = one(ward, victim, SUCTIONS_S)
    assert not fate.wrong, fate
    assert fate.depth_mm > INSIDE_MM


@pytest.fixture(scope="module")
def ward_on_a_bus() -> Iterator[Ward]:
    """Its machine is drives on a bus."""
    with (
        running(begins=False, on_bus=True) as room,
        kept_up(Ward(room, room.folder / "recordings")) as made,
    ):
        yield made


def instants(count: int, seed: int) -> list[float]:
    """So many of a cycle, by turns any of them and one at an edge of a phase."""
    chance, found = random.Random(seed), []
    for number in range(count):
        edge_s = chance.choice(EDGES_S) + chance.uniform(-EDGE_S, EDGE_S)
        found.append(round(max(0.0, edge_s if number % 2 else chance.uniform(0.0, CYCLE_S)), 3))
    return found


@pytest.mark.soak
@pytest.mark.parametrize("at_s", instants(100, seed=3))
def test_over_a_bus_the_drives_act_in_time_whenever_the_controller_dies(
    ward_on_a_bus: Ward, at_s: float, record_property: Callable[[str, object], None]
) -> None:
    """Within the heartbeat's time and a period; deterministic ones: `machine/drives`."""
    fate = one(ward_on_a_bus, "control", at_s)
    record_property("fate", json.dumps(fate._asdict()))
    assert not fate.wrong, fate


@pytest.mark.soak
@pytest.mark.parametrize(
    ("victim", "at_s", "hung"),
    [*AT_ITS_BEGINNING, *deaths(200, seed=2)],
)
def test_whoever_dies_or_hangs_at_any_instant_of_a_cycle_leaves_the_tip_outside(
    ward: Ward,
    victim: str,
    at_s: float,
    hung: str | None,
    record_property: Callable[[str, object], None],
) -> None:
    fate = one(ward, victim, at_s, hung)
    record_property("fate", json.dumps(fate._asdict()))  # for the page of evidence
    assert not fate.wrong, fate
