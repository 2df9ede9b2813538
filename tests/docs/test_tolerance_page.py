"""The tolerance page: its calculation holds on simulated noise, its rows are of what there is."""

import importlib
import math
import re

import numpy as np
import pytest

from docs.generator.catalogue import DOCS
from docs.generator.safety.tolerance import duration, noise, page, sensor_error
from docs.generator.safety.tolerance.left_out import LEFT_OUT
from docs.generator.safety.tolerance.threshold import Chance, Threshold, value_of
from opensuction.twin import parameter
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.parameter import SENSORS
from tests.evidence import tolerance_run

SAMPLES = 1_000_000
SOURCES = DOCS.parent / "src" / "opensuction"
WATCHED = [
    f"safety.{room}.{path.stem}"
    for room in ("watch", "head")
    for path in sorted((SOURCES / "safety" / room).glob("[a-z]*.py"))
] + [
    "safety.governor.judgement",
    "safety.invalid_ticks",
    "safety.limits",
    "procedure.cycle.check",
]
"""Modules that compare what is read with something."""
THRESHOLDS = page.thresholds()


def follow(values: noise.Array, share: float) -> noise.Array:
    """A filter of first order, sample by sample."""
    found, last = np.empty_like(values), 0.0
    for i, value in enumerate(values):
        last += share * (value - last)
        found[i] = last
    return found


def white(seed: int) -> noise.Array:
    return np.random.default_rng(seed).standard_normal(SAMPLES)


@pytest.mark.parametrize("time_s", [0.01, 0.02, 0.1])
def test_a_filter_of_first_order_has_its_closed_form(time_s: float) -> None:
    share = noise.share(time_s)
    found = noise.low_pass(time_s)
    assert found.ratio == pytest.approx(math.sqrt(share / (2.0 - share)), rel=1e-9)
    assert found.likeness == pytest.approx(1.0 - share, rel=1e-9)


def test_two_filters_leave_what_a_simulation_has() -> None:
    behind = follow(follow(white(1), noise.share(0.02)), noise.share(0.1))[2000:]
    found = noise.low_pass(0.02, 0.1)
    assert float(np.std(behind)) == pytest.approx(found.ratio, rel=0.05)
    assert found.ratio == pytest.approx(math.sqrt(0.001 / (2.0 * (0.02 + 0.1))), rel=0.02)
    assert float(np.corrcoef(behind[1:], behind[:-1])[0, 1]) == pytest.approx(
        found.likeness, abs=1e-4
    )


def test_a_rate_over_a_window_has_the_noise_of_a_simulation() -> None:
    smooth = follow(white(2), noise.share(0.02))
    rates = ((smooth - follow(smooth, noise.share(0.1))) / 0.1)[2000:]
    assert float(np.std(rates)) == pytest.approx(noise.rate(0.02, 0.1).ratio, rel=0.03)


@pytest.mark.parametrize("sigmas", [1.0, 2.0, 3.0])
def test_crossings_come_as_often_as_in_a_simulation(sigmas: float) -> None:
    found = noise.low_pass(0.02)
    beyond = follow(white(3), noise.share(0.02)) > sigmas * found.ratio
    counted = int(np.sum(beyond[1:] & ~beyond[:-1]))
    expected = noise.crossings_per_h(found.likeness, sigmas) * SAMPLES / noise.TICKS_PER_H
    assert counted == pytest.approx(expected, abs=4.0 * math.sqrt(expected))


def test_a_level_below_the_mean_is_reached_always() -> None:
    assert noise.crossings_per_h(0.95, -1.0) == noise.crossings_per_h(0.95, 0.0)
    assert noise.crossings_per_h(0.95, 0.0) > noise.crossings_per_h(0.95, 0.01)


def test_even_noise_ends() -> None:
    draws = noise.ROOT_3 * np.random.default_rng(4).uniform(-1.0, 1.0, SAMPLES)
    assert float(np.mean(draws > 1.0)) == pytest.approx(noise.even_beyond(1.0), abs=0.002)
    assert noise.even_beyond(noise.ROOT_3) == 0.0


def test_runs_of_late_messages_come_as_often_as_in_a_simulation() -> None:
    late = np.random.default_rng(5).uniform(size=SAMPLES) < 0.1
    runs = int(np.sum(late[2:] & late[1:-1] & late[:-2]))
    expected = noise.runs_per_h(0.1, 3) * SAMPLES / noise.TICKS_PER_H
    assert runs == pytest.approx(expected, rel=0.1)


def test_a_hum_is_filtered_as_in_a_simulation() -> None:
    ticks = np.arange(20_000) * noise.DT_S
    hum = math.sqrt(2.0) * np.sin(2.0 * math.pi * 50.0 * ticks)
    behind = follow(hum, noise.share(0.02))[10_000:]
    assert float(np.std(behind)) == pytest.approx(noise.hum(1.0, 50.0, 0.02), rel=1e-3)


@pytest.mark.parametrize("row", THRESHOLDS, ids=lambda row: f"{row.constants[0][1]}: {row.unit}")
def test_a_threshold_is_a_constant_and_catches_a_fault(
    row: Threshold,
) -> None:
    assert all(math.isfinite(value_of(constant)) for constant in row.constants)
    assert row.faults
    assert all(fault in ROWS for fault in row.faults)
    assert set(row.errors) <= SENSORS.keys()
    assert row.takes_s > 0.0
    assert row.margin > 0.0


def test_a_constant_that_is_gone_is_noticed() -> None:
    with pytest.raises(AttributeError):
        value_of(("safety.watch.vacuum_signature", "GONE"))


def test_the_durations_that_have_no_margin_are_named() -> None:
    rows = duration.durations()
    assert {row.outlives for row in rows if not row.waits_s > row.worst_s} == {
        "an oximeter that says nothing",
        "the breath before a cough, of a patient without breaths of their own",
        "a breath of their own, neonate",
        "a breath of their own, child",
    }
    for row in rows:
        assert all(value_of(constant) > 0.0 for constant in row.constants)
        assert all(fault in ROWS for fault in row.faults)


def source_of(module: str) -> str:
    return (SOURCES / f"{module.replace('.', '/')}.py").read_text(encoding="utf-8")


def is_constant(name: str, value: object) -> bool:
    return name.isupper() and isinstance(value, int | float)


def test_every_constant_of_what_is_watched_has_a_row_or_a_reason() -> None:
    """One that is new is looked at: what reaches it, and how far it is from that."""
    rows = {constant for row in THRESHOLDS for constant in row.constants}
    rows |= {constant for row in duration.durations() for constant in row.constants}
    excused = [
        (module, name)
        for constants in LEFT_OUT.values()
        for module, names in constants.items()
        for name in names
    ]
    assert len(set(excused)) == len(excused)
    assert not rows & set(excused)
    found = {
        (module, name)
        for module in WATCHED
        for name, value in vars(importlib.import_module(f"opensuction.{module}")).items()
        if is_constant(name, value)
        and re.search(
            rf"^{name} = ", (SOURCES / f"{module.replace('.', '/')}.py").read_text(), re.M
        )
    }
    assert found <= rows | set(excused)
    assert set(excused) <= found


def test_more_noise_is_never_further_from_a_threshold() -> None:
    for row in THRESHOLDS:
        if row.chance in (Chance.LATE, Chance.NONE):
            continue
        clean = dict.fromkeys(SENSORS, 0.0) | {"late_share": 0.0}
        assert row.bear(clean).static <= row.bear(sensor_error.worst()).static
        assert row.bear(clean).sigma < row.bear(sensor_error.worst()).sigma


def test_what_stands_near_is_what_was_found_so() -> None:
    """A threshold that comes nearer is looked at and written about before it is listed."""
    named = {(row.constants[0][1], row.compared.split(", ")[-1]) for row in page.near()}
    assert named == {
        ("CLINICAL.jam_n", "bedside"),
        ("BENCH.jam_n", "bench"),
        ("FORCE_MARGIN", "bench"),
        ("LEAK_SHARE", "of 80 mmHg"),
        ("SLACK_N", "bedside"),
        ("SLACK_N", "bench"),
    }


def test_the_campaign_is_of_the_sensors_that_are_sold() -> None:
    measured = page.measured()
    assert [row["error"] for row in measured["errors"]] == list(tolerance_run.ERRORS)
    for row in measured["errors"]:
        assert row["rungs"][0]["error"] == pytest.approx(sensor_error.worst()[row["error"]])
        assert row["largest_value"] == SENSORS[row["error"]].high
    for corner in measured["corners"].values():
        for name, value in corner["values"].items():
            spread = parameter.SPREAD_LIMIT * parameter.CLINICAL[name].spread
            assert abs(value - parameter.CLINICAL[name].value) == pytest.approx(spread)


def test_every_simulated_hour_belongs_to_a_threshold() -> None:
    measured = page.measured()
    simulated = {row.simulated for row in THRESHOLDS if row.simulated}
    assert simulated == measured["hours"].keys() | measured["refusals"].keys()


def test_no_noise_of_a_sold_sensor_tripped_in_an_hour() -> None:
    found = {name: row["worst"] for name, row in page.measured()["hours"].items()}
    assert len(found) == 10
    assert not any(found.values())
