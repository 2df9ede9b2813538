import json

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from opensuction.report import series
from opensuction.simulation import closed_loop
from tests.report import example


@given(
    arrays.arrays(np.float64, st.integers(1, 500), elements=st.floats(-1e3, 1e3)),
    st.integers(1, 60),
)
def test_thinning_keeps_the_extremes_and_both_ends(
    values: np.ndarray[tuple[int], np.dtype[np.float64]], buckets: int
) -> None:
    kept = series.keep_rows([values], [], buckets)
    assert np.all(np.diff(kept) > 0)
    assert kept[0] == 0
    assert kept[-1] == values.size - 1
    assert values[kept].min() == values.min()
    assert values[kept].max() == values.max()
    assert kept.size <= 3 * buckets + 1


def test_spike_of_one_tick_survives() -> None:
    trace = example.trace()
    trace["readings.line_vacuum_mmhg"][17_123] = 149.0
    payload = series.machine(example.summary(), trace)
    assert max(payload["line_vacuum"]) == 149.0
    assert 17.123 in payload["time"]


def test_first_row_of_every_phase_is_kept() -> None:
    summary = example.summary()
    payload = series.machine(summary, example.trace())
    assert {phase.start_s for phase in summary.phases} <= set(payload["time"])


def test_every_series_has_one_value_for_each_time() -> None:
    payload = series.machine(example.summary(), example.trace())
    assert {len(values) for values in payload.values()} == {len(payload["time"])}
    assert np.all(np.diff(payload["time"]) > 0)


def test_value_that_is_not_finite_becomes_null() -> None:
    trace = example.trace()
    trace["truth.tip_vacuum_mmhg"][100:200] = np.nan
    payload = series.machine(example.summary(), trace)
    assert None in payload["tip_vacuum"]
    json.dumps(payload, allow_nan=False)


def test_missing_columns_are_left_out() -> None:
    trace = {name: example.trace()[name] for name in ("time_s", "readings.head_mm")}
    assert set(series.machine(example.summary(), trace)) == {"time", "head", "inward"}


def test_empty_trace_gives_nothing_to_draw() -> None:
    assert series.machine(example.summary(), {}) == {}
    assert series.machine(example.summary(), example.trace(rows=0)) == {}


def test_jitter_is_no_reversal() -> None:
    head = np.concatenate([np.linspace(0, 90, 500), np.full(200, 90.0), np.linspace(90, 0, 500)])
    head += 0.05 * np.sin(np.arange(head.size))
    inward = series.directions(head, series.REVERSAL_MM)
    assert inward[:700].all()
    assert not inward[710:].any()


def test_every_column_that_is_drawn_is_one_of_the_trace() -> None:
    estimated = {"estimate.tip_mm"}  # of a recording alone
    drawn = {entry.column for entry in (*series.MACHINE, *series.PATIENT)} - estimated
    wanted = drawn | set(series.MEASURED) | {"time_s"}
    assert wanted <= set(closed_loop.COLUMNS)


def test_machine_and_patient_are_shown_until_the_record_ends() -> None:
    summary, trace = example.on_patient(), example.breathing_trace()
    times = np.asarray(series.machine(summary, trace)["time"])
    assert times[-1] == 121.499
    # The cycle of 31.5 s, and 2 s, keep their detail.
    assert np.count_nonzero(times <= 33.5) > np.count_nonzero(times > 33.5)
    shown = series.patient(summary, trace)
    assert shown["time"][-1] == 121.499
    assert min(shown["spo2"]) == 91.4
    assert {len(values) for values in shown.values()} == {len(shown["time"])}


def test_every_breath_survives_the_thinning() -> None:
    shown = series.patient(example.on_patient(), example.breathing_trace())
    volume = np.asarray(shown["lung_volume"])
    middle = (np.asarray(shown["time"]) + 2.0) // 4.0  # breaths of 4 s, fullest in the middle
    swings = [np.ptp(volume[middle == breath]) for breath in range(1, 30)]
    assert min(swings) > 400.0  # of 420 mL


def test_bench_has_no_patient_to_draw() -> None:
    trace = example.trace() | {"truth.spo2_percent": np.zeros(31_501)}
    assert series.patient(example.summary(), trace) == {}
