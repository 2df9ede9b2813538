"""Values of a file in place of a table's: meant as they are, in range, by name."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.settings.toml_file import change
from opensuction.twin import parameter
from opensuction.twin.parameter import CLINICAL


def test_a_value_is_meant_and_not_drawn() -> None:
    table = change(CLINICAL, {"no_load_mm_per_s": 55}, "twin", "m.toml")
    for seed in range(20):
        assert parameter.draw(table, seed)["no_load_mm_per_s"] == 55.0
    assert table["no_load_mm_per_s"].source == "[file] m.toml"


def test_a_value_with_a_spread_is_drawn_and_others_stay() -> None:
    given = {"no_load_mm_per_s": {"value": 55, "spread": 2.0}}
    table = change(CLINICAL, given, "twin", "m.toml")
    drawn = {parameter.draw(table, seed)["no_load_mm_per_s"] for seed in range(20)}
    assert len(drawn) == 20
    assert {name for name in table if table[name] != CLINICAL[name]} == set(given)


@given(st.sampled_from(list(CLINICAL)), st.floats(allow_nan=True, allow_infinity=True))
def test_only_plausible_numbers_enter(name: str, value: float) -> None:
    entry = CLINICAL[name]
    try:
        table = change(CLINICAL, {name: value}, "twin", "m.toml")
    except InputError as refused:
        assert not entry.low <= value <= entry.high
        assert str(refused).startswith("m.toml: twin.")
        assert "\n" not in str(refused)
        return
    assert entry.low <= table[name].value <= entry.high


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"no_load_mm_per_z": 55.0},
            "unknown key twin.no_load_mm_per_z: did you mean 'no_load_mm_per",
        ),
        ({"gain": "much"}, "twin.gain is 'much', not a number; give a number from 0.8 to 1.05"),
        ({"gain": True}, "twin.gain is true, not a number"),
        ({"gain": 10**400}, "not a finite number; give a number from 0.8 to 1.05"),
        ({"supply_v": 0.0}, "twin.supply_v is 0 V; give a number from 12 to 48 V"),
        ({"supply_v": {"value": 24.0}}, "twin.supply_v.spread is missing"),
        (
            {"supply_v": {"value": 24.0, "spraed": 1.0}},
            "twin.supply_v.spraed: did you mean 'spread'",
        ),
        ({"supply_v": {"value": 24.0, "spread": -1.0}}, "spread is -1, it should be 0 or more"),
        ({"supply_v": {"value": 14.0, "spread": 2.0}}, "twin.supply_v is 14 +- 2.5 x 2 V; give"),
        ([1.0], "twin is a list, not a section"),
    ],
)
def test_anything_else_is_refused_with_name_value_and_range(given: object, words: str) -> None:
    with pytest.raises(InputError) as refused:
        change(CLINICAL, given, "twin", "m.toml")
    assert words in str(refused.value)
