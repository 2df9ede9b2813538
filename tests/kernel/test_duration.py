"""Duration for which a condition has held, with and without breaks."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel import arithmetic

DT_S = 0.01


def added(holds: list[bool], fade: float) -> float:
    seconds = 0.0
    for one in holds:
        seconds = arithmetic.add_up_duration(seconds, one, fade, DT_S)
    return seconds


@given(st.lists(st.booleans(), max_size=200), st.floats(0.1, 4.0))
def test_breaks_take_their_share_off_and_never_more_than_there_is(
    holds: list[bool], fade: float
) -> None:
    held = added(holds, fade)
    assert 0.0 <= held <= sum(holds) * DT_S + 1e-9
    assert held >= (sum(holds) - fade * (len(holds) - sum(holds))) * DT_S - 1e-9


@pytest.mark.parametrize(("fade", "least"), [(0.25, 0.2), (0.5, 1 / 3), (1.0, 0.5), (2.0, 2 / 3)])
def test_only_what_holds_for_its_share_of_the_time_adds_up(fade: float, least: float) -> None:
    for share, grows in ((least - 0.05, False), (least + 0.05, True)):
        period = round(20 * share)
        pattern = ([True] * period + [False] * (20 - period)) * 50
        assert (added(pattern, fade) > 0.2) == grows
