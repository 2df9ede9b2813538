import re

import pytest

from opensuction.twin import parameter, preset
from opensuction.twin.parameter import BENCH, CLINICAL
from opensuction.twin.parameter_row import Parameter

TAGS = ("[paper]", "[datasheet]", "[calibrated]", "[computed]", "[assumed]")
Values = dict[str, float]


def outcome(values: Values) -> str:
    """Everything that a set of parameters decides, as text."""
    twin = preset.machine(values)
    state = preset.park(twin, values, 0.0, seed=1, run=2)
    arrays = (twin.transmission.widths_mm, state.bedside.secretion_ml.tolist())
    return f"{arrays} {twin} {state}"


@pytest.mark.parametrize("table", [BENCH, CLINICAL])
@pytest.mark.parametrize("name", BENCH)
def test_every_entry_has_unit_meaning_and_source(table: dict[str, Parameter], name: str) -> None:
    entry = table[name]
    assert re.fullmatch(r"[A-Za-z0-9%/ ]+", entry.unit)
    assert len(entry.meaning) > 5
    assert entry.source.startswith(TAGS)
    assert entry.spread >= 0.0
    reach = parameter.SPREAD_LIMIT * entry.spread  # every draw is plausible
    assert entry.low <= entry.value - reach <= entry.value + reach <= entry.high
    # No draw may change what a parameter means by changing its sign; an offset has either.
    if entry.spread and entry.value != 0.0:
        assert parameter.SPREAD_LIMIT * entry.spread < abs(entry.value)


@pytest.mark.parametrize("name", BENCH)
def test_every_entry_changes_the_machine(name: str) -> None:
    values = parameter.nominal(BENCH)
    entry = BENCH[name]
    other = 1.01 * entry.value if entry.value != 0.0 else 0.5 * entry.high
    changed = {**values, name: other}
    assert outcome(changed) != outcome(values)


def test_the_bedside_machine_has_the_bench_s_parameters_in_their_order() -> None:
    assert list(CLINICAL) == list(BENCH)
    for name in BENCH:
        assert CLINICAL[name].unit == BENCH[name].unit


def test_no_value_is_asked_for_that_the_table_lacks() -> None:
    assert outcome(parameter.nominal(BENCH))


@pytest.mark.parametrize("seed", [0, 1, 2**32 - 1])
def test_a_draw_is_repeatable_and_bounded(seed: int) -> None:
    values = parameter.draw(BENCH, seed)
    assert values == parameter.draw(BENCH, seed)
    for name, entry in BENCH.items():
        assert abs(values[name] - entry.value) <= parameter.SPREAD_LIMIT * entry.spread + 1e-15


def test_seeds_differ() -> None:
    assert len({tuple(parameter.draw(BENCH, seed).values()) for seed in range(50)}) == 50


def test_draws_have_their_spread() -> None:
    entry = BENCH["bend_rad"]
    draws = [parameter.draw({"bend_rad": entry}, seed)["bend_rad"] for seed in range(2000)]
    mean = sum(draws) / len(draws)
    deviation = (sum((draw - mean) ** 2 for draw in draws) / len(draws)) ** 0.5
    # Four standard errors; the cut at 2.5 deviations takes 2 % off the deviation.
    assert mean == pytest.approx(entry.value, abs=4.0 * entry.spread / len(draws) ** 0.5)
    assert deviation == pytest.approx(0.98 * entry.spread, rel=4.0 / (2.0 * len(draws)) ** 0.5)


@pytest.mark.parametrize("spread", [0.0, 0.5, 2.0, 3.0])
def test_a_wider_draw_is_as_much_further_from_nominal_up_to_three_deviations(
    spread: float,
) -> None:
    at_limit = 0
    for seed in range(20):
        usual, wide = parameter.draw(CLINICAL, seed), parameter.draw(CLINICAL, seed, spread)
        for name, entry in CLINICAL.items():
            off = (usual[name] - entry.value) * spread
            far = parameter.FAR_LIMIT * entry.spread
            expected = entry.value + min(max(off, -far), far)
            if spread > 1.0:
                expected = min(max(expected, entry.low), entry.high)
            # One that is cut as usual is cut no sooner here.
            if abs(usual[name] - entry.value) < 2.49 * entry.spread:
                assert wide[name] == pytest.approx(expected, abs=1e-12)
            at_limit += abs(abs(wide[name] - entry.value) - far) < 1e-12 < entry.spread
    assert (at_limit > 0) == (spread > 1.0)
    assert parameter.draw(CLINICAL, 1, 1.0) == parameter.draw(CLINICAL, 1)


def test_neither_a_new_parameter_nor_a_new_spread_changes_other_draws() -> None:
    before = parameter.draw(BENCH, 7)
    grown: dict[str, Parameter] = {
        "new_mm": Parameter(1.0, 0.1, "mm", "a new one", "[assumed]", 0.0, 2.0),
        **BENCH,
        "supply_v": BENCH["supply_v"]._replace(spread=0.5),
    }
    after = parameter.draw(grown, 7)
    for name in BENCH:
        if name != "supply_v":
            assert after[name] == before[name]
    assert after["supply_v"] != before["supply_v"]
