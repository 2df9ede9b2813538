"""Figures of the leaderboard against closed forms; its page; recordings of others."""

import math
from pathlib import Path

import numpy as np
import pytest

from opensuction.evidence.leaderboard import contender, data_set, leaderboard, leaderboard_page
from opensuction.evidence.leaderboard.data_set_table import DATA_SETS
from opensuction.evidence.leaderboard.leaderboard import Entry, LeaderboardResult
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from tests.evidence.leaderboard.data_set_example import LINE, PERCENT, RIPPLE, SAMPLES, line

SHARED = Path(__file__).resolve().parents[4] / "shared" / "data"
PAGE = Path(__file__).resolve().parents[3] / "docs" / "reference" / "leaderboard.md"
PUBLISHED = 0.045104
"""RRSE of SysIdentPy on the simulated damper, with sign(v) as a third input."""


class Mean:
    """Predicts the mean of what it was fitted to."""

    def fit(self, rows: Array, output: Array) -> None:
        """Keep the mean; there are no rows of the held-out part."""
        assert len(rows) == len(output) == SAMPLES // 2
        self.mean = float(output.mean())

    def predict(self, rows: Array) -> Array:
        """The mean for every row."""
        assert rows.shape == (SAMPLES, 1)
        return np.full(len(rows), self.mean)


class Broken(Mean):
    """Fails in two lines."""

    def predict(self, rows: Array) -> Array:
        """Raise."""
        raise RuntimeError(f"no\nmatrix of {rows.ndim}")


@pytest.fixture(scope="module")
def found() -> LeaderboardResult:
    """The table of a line, a mean and an estimator that fails."""
    return leaderboard.run(models=("straight-line", Mean(), Broken()), data_sets=(LINE,))


def entry_of(found: LeaderboardResult, model: str) -> Entry:
    """The entry of a model."""
    return next(one for one in found.entries if one.model == model)


def test_the_line_leaves_the_ripple(found: LeaderboardResult) -> None:
    entry = entry_of(found, "straight-line")
    output = line()["y"]
    assert entry.error is not None
    assert entry.error.rmse == pytest.approx(RIPPLE, rel=1e-9)
    assert entry.error.rmse_ci95 == pytest.approx((RIPPLE, RIPPLE), rel=1e-9)  # in every block
    assert entry.error.largest == pytest.approx(RIPPLE, rel=1e-9)
    assert entry.error.rmse_percent_of_range == pytest.approx(100.0 * RIPPLE / np.ptp(output))
    assert entry.error.rrse == pytest.approx(RIPPLE / output[SAMPLES // 2 :].std())
    assert entry.fitted_rrse == pytest.approx(0.0, abs=1e-12)


def test_places_and_what_cannot_be_fitted(found: LeaderboardResult) -> None:
    assert [(one.model, one.place) for one in found.entries] == [
        ("straight-line", 1),
        ("Mean", 2),
        ("Broken", None),
    ]
    mean, broken = entry_of(found, "Mean"), entry_of(found, "Broken")
    assert mean.error is not None
    assert mean.error.rrse == pytest.approx(1.0, abs=0.01)
    assert not mean.like_best
    assert broken.refused == "RuntimeError: no matrix of 2"
    summary = {one.name: one for one in found.models}
    assert (summary["Broken"].scored, summary["Broken"].refused) == (0, 1)
    assert summary["Mean"].mean_place == 2.0


def test_the_interval_of_independent_errors() -> None:
    # The root mean square of n normal errors of deviation s scatters by s / sqrt(2 n).
    samples = data_set.cut(LINE, line())
    blocks = np.array(
        [
            np.ptp(leaderboard.measure(samples.output + noise, samples)[0].rmse_ci95)
            for noise in np.random.default_rng(3).normal(size=(30, SAMPLES)) * 50.0
        ]
    )
    expected = 2.0 * 1.96 * 50.0 / math.sqrt(SAMPLES)
    assert np.median(blocks) == pytest.approx(expected, rel=0.2)


@pytest.mark.parametrize("model", ["straight-line", "prandtl-ishlinskii", "maxwell-slip"])
def test_what_was_measured_of_the_held_out_part_is_not_used(model: str) -> None:
    samples = data_set.cut(LINE, line())
    other = samples.output.copy()
    other[samples.fitted :] = np.linspace(-9.0, 9.0, SAMPLES - samples.fitted)
    (chosen,) = contender.select((model,))
    np.testing.assert_array_equal(
        chosen.predict(samples), chosen.predict(samples._replace(output=other))
    )


def test_nothing_that_can_be_used_is_refused() -> None:
    with pytest.raises(InputError, match="none of 1 data sets can be used"):
        leaderboard.run(models=("straight-line",), data_sets=(DATA_SETS["wall"],))


def test_the_page_has_every_entry_and_what_is_missing(tmp_path: Path) -> None:
    published = data_set.Published("somebody", 0.25, "K")
    chosen = (LINE._replace(published=(published,)), DATA_SETS["wall"])
    page = leaderboard_page.markdown(leaderboard.run(tmp_path, ("straight-line", Broken()), chosen))
    assert f"| 1 | straight-line | 0.1 | {PERCENT} ({PERCENT} to {PERCENT}) |" in page
    assert "\nNot fitted: Broken: RuntimeError: no matrix of 2.\n" in page
    assert "|  | *somebody* |  |  | 0.25 |  |  |" in page
    assert "| wall | not there | no wall_ts1.csv in" in page


@pytest.mark.sweep
@pytest.mark.skipif(not SHARED.exists(), reason="real recordings are not here")
def test_recordings_of_others_as_the_page_tells_of_them() -> None:
    models = ("maxwell-slip", "straight-line", "modified-bouc-wen", "bouc-wen-oscillator")
    found = leaderboard.run(SHARED, models)
    assert {one.state for one in found.data_sets} == {data_set.THERE, data_set.GENERATED}
    page = PAGE.read_text("utf-8")
    for entry in found.entries:
        if entry.error is None:
            assert entry.data_set == "bouc-wen-benchmark"  # a model without inertia
            continue
        section = page.split(f"### {entry.data_set}\n")[1].split("### ")[0]
        cells = section.split(f"| {entry.model} | ")[1].split(" | ")
        shown = float(cells[2].split(" ")[0])
        assert entry.error.rrse == pytest.approx(shown, rel=0.02)
    damper = entry_of(found, "modified-bouc-wen")
    assert damper.error is not None
    assert damper.error.rrse_ci95[1] < PUBLISHED
