"""Whoever dies in a cycle: the tip comes out, people are told, and what was kept is not lost."""

from collections.abc import Iterator

import pytest

from tests.runtime.kills import VICTIMS, Ward, instants, one, supervised
from tests.runtime.machine_room import INSIDE_MM

pytestmark = pytest.mark.real_time

SUCTIONS_S = 6.5
"""After the start's button the tip is at its depth, and suction is on."""


@pytest.fixture(scope="module")
def ward() -> Iterator[Ward]:
    with supervised() as made:
        yield made


@pytest.mark.parametrize(
    "victim",
    [
        "control",
        *(pytest.param(one, marks=pytest.mark.sweep) for one in VICTIMS if one != "control"),
    ],
)
def test_whoever_dies_with_the_tip_inside_it_comes_out_and_the_record_has_its_end(
    ward: Ward, victim: str
) -> None:
    fate = one(ward, victim, SUCTIONS_S)
    assert not fate.wrong, fate
    assert fate.depth_mm > INSIDE_MM


@pytest.mark.parametrize(
    ("victim", "at_s"),
    [
        *(pytest.param(*one, marks=pytest.mark.sweep) for one in instants(2, seed=3)),
        *(pytest.param(*one, marks=pytest.mark.soak) for one in instants(200, seed=2)),
    ],
)
def test_whoever_dies_at_any_instant_of_a_cycle_leaves_the_tip_outside(
    ward: Ward, victim: str, at_s: float
) -> None:
    fate = one(ward, victim, at_s)
    assert not fate.wrong, fate
