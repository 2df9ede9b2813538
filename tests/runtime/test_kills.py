"""Whoever dies in a cycle: the tip comes out, people are told, and what was kept is not lost."""

from collections.abc import Sequence

import pytest

from tests.runtime.kills import VICTIMS, Fate, campaign

pytestmark = pytest.mark.real_time


def assert_all_well(fates: Sequence[Fate]) -> None:
    assert not [fate for fate in fates if fate.wrong]


@pytest.mark.parametrize(
    ("deaths", "seed"),
    [(len(VICTIMS), 1), pytest.param(4 * len(VICTIMS), 3, marks=pytest.mark.sweep)],
)
def test_of_some_deaths_none_leaves_the_tip_inside_or_the_record_without_an_end(
    deaths: int, seed: int
) -> None:
    fates = campaign(deaths, seed)
    assert_all_well(fates)
    assert {fate.victim for fate in fates} == set(VICTIMS)
    assert any(fate.out_s > 0.5 for fate in fates), "nobody died with the tip in the airway"


@pytest.mark.soak
def test_of_two_hundred_deaths_none_leaves_the_tip_inside() -> None:
    assert_all_well(campaign(200, seed=2))
