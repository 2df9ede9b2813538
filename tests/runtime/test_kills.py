"""Whoever dies in a cycle: the tip comes out, people are told, and what was kept is not lost."""

from collections.abc import Sequence

import pytest

from tests.runtime.kills import VICTIMS, Fate, campaign


def assert_all_well(fates: Sequence[Fate]) -> None:
    assert not [fate for fate in fates if fate.wrong]


def test_of_twenty_deaths_none_leaves_the_tip_inside_or_the_record_without_an_end() -> None:
    fates = campaign(20, seed=1)
    assert_all_well(fates)
    assert {fate.victim for fate in fates} == set(VICTIMS)
    assert any(fate.out_s > 0.5 for fate in fates), "nobody died with the tip in the airway"


@pytest.mark.soak
def test_of_two_hundred_deaths_none_leaves_the_tip_inside() -> None:
    assert_all_well(campaign(200, seed=2))
