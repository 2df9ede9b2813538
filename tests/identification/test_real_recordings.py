"""Real recordings, of a cable-driven grasper and of dampers, if they lie beside the repository."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import loadmat

from opensuction.identification.judgement.diagnosis import Labels
from opensuction.identification.judgement.recommendation import Aim
from opensuction.identification.workbench import FittedModel, compare, identify

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data" / "mrd"
SETTLED = 50
"""The load switches on within the first .5 s at 100 Hz."""
LABELS = Labels("spindle_deg", "jaw_deg", "deg", "deg", "t_s")
RUNS = ("00", "25", "45")
FEW = RUNS[:2]
"""The one that is predicted worst and the one that is predicted best."""
LIMITS = {"00": 0.55, "25": 0.27, "45": 0.30}
"""Percent of range that the modified Dahl model may leave on the second half."""
BEFORE = {"00": 0.516, "25": 0.174, "45": 0.182}
"""Percent of range that the model recommended before banks and readouts left there."""
SHARE = 0.85
"""Of that, at most."""
TRANSFER = 0.16
"""Percent of range that a model of one recording may leave on another at another speed."""

STRANGERS = FOLDER.parent / "strangers"
TREES = {"mr_damper": 1.74, "friction_damper": 6.79}
"""Percent of range that extremely randomised trees on lagged inputs left of the second half (100 of
them, two samples a leaf, the best of four sets of 10 to 20 lags)."""
OF_TREES = 1.5
"""Of that, at most."""

pytestmark = [
    pytest.mark.sweep,
    pytest.mark.skipif(not FOLDER.exists(), reason="real recordings are not here"),
]


def load(run: str, begins: int) -> NDArray[np.float64]:
    """A recording from a sample on: time, motor, spindle, jaw, torque."""
    table: NDArray[np.float64] = np.loadtxt(
        FOLDER / f"tool4_L4_{run}.csv", delimiter=",", skiprows=1
    )
    return table[begins:]


@pytest.fixture(
    scope="module",
    params=[FEW, pytest.param(RUNS, marks=pytest.mark.soak)],
    ids=lambda runs: f"{len(runs)} runs",
)
def results(request: pytest.FixtureRequest) -> dict[str, list[FittedModel]]:
    compared = {}
    for run in request.param:
        table = load(run, SETTLED)
        compared[run] = compare(table[:, 2], -table[:, 3], table[:, 0], 0.5, LABELS)
    return compared


def holdout(results: list[FittedModel], model: str) -> float:
    return next(each.holdout_rmse_percent_of_range for each in results if each.model == model)


def test_modified_dahl_predicts_the_second_half(results: dict[str, list[FittedModel]]) -> None:
    for run, fitted in results.items():
        assert holdout(fitted, "modified-dahl") <= LIMITS[run], run


def test_the_recommended_model_predicts_better(results: dict[str, list[FittedModel]]) -> None:
    ratios = []
    for run, fitted in results.items():
        best = fitted[0]
        assert best.recommended
        assert best.holdout_rmse_percent_of_range <= SHARE * BEFORE[run], run
        assert best.reasons
        ratios.append(best.holdout_rmse_percent_of_range / holdout(fitted, "modified-dahl"))
    assert np.mean(ratios) <= 0.9
    assert max(ratios) <= 1.05


def test_units_are_degrees(results: dict[str, list[FittedModel]]) -> None:
    found = next(each for each in results["25"] if each.model == "modified-dahl")
    assert found.parameters["decay"].unit == "1/deg"
    assert found.parameters["slope"].low < 0.9043 < found.parameters["slope"].high


@pytest.mark.parametrize(
    ("fitted", "predicted"), [("25", "45"), pytest.param("45", "25", marks=pytest.mark.soak)]
)
def test_another_speed_is_predicted(fitted: str, predicted: str) -> None:
    """One recording, then the other without its first second, in which the load settles."""
    one, other = load(fitted, SETTLED), load(predicted, 2 * SETTLED)
    table = np.concatenate([one, other])
    share = (len(other) + 0.5) / len(table)
    best = compare(table[:, 2], -table[:, 3], None, share, LABELS, aim=Aim("transfer"))[0]
    assert best.fitted_samples == len(one)
    rest = (-table[:, 3] - best.fitted)[len(one) :]
    assert 100.0 * np.sqrt(np.mean(rest**2)) / np.ptp(other[:, 3]) <= TRANSFER


@pytest.mark.parametrize(
    ("run", "limit"),
    [
        ("45", 0.210),
        *(pytest.param(*one, marks=pytest.mark.soak) for one in (("00", 0.413), ("25", 0.157))),
    ],
)
def test_motor_to_jaw_is_predicted(run: str, limit: float) -> None:
    """limit: percent of range that the model recommended before left."""
    table = load(run, SETTLED)
    best = compare(table[:, 1], table[:, 3], table[:, 0], 0.5)[0]
    assert best.holdout_rmse_percent_of_range <= SHARE * limit


def load_damper(name: str) -> tuple[NDArray[np.float64], ...]:
    """Input, output and time."""
    if name == "mr_damper":
        table = loadmat(STRANGERS / "mr_ensaio1.mat")
        return table["dist"].ravel(), table["forc"].ravel(), table["Tout"].ravel()
    rows = np.loadtxt(STRANGERS / "friction_damper.csv", delimiter=",", skiprows=1)
    return rows[:, 1], rows[:, 5], rows[:, 0]


@pytest.mark.parametrize(
    "part",
    [
        slice(None),
        *(pytest.param(one, marks=pytest.mark.soak) for one in (slice(0, 1500), slice(1500, None))),
    ],
)
def test_an_ordinary_bouc_wen_fit_of_a_damper_is_reached(part: slice) -> None:
    input_, output, time_s = (column[part] for column in load_damper("mr_damper"))
    found = identify(input_, output, time_s, "bouc-wen")
    assert found.rmse_percent_of_range < 7.4  # of all of it; with slope and gain bounded 13.9
    assert not any(warning.startswith("Not determined") for warning in found.warnings)


@pytest.mark.parametrize(
    "name", [pytest.param("mr_damper", marks=pytest.mark.soak), "friction_damper"]
)
def test_rubbing_that_depends_on_speed_is_predicted_as_learners_do(name: str) -> None:
    input_, output, time_s = load_damper(name)
    best, *others = compare(input_, output, time_s, 0.5)
    assert best.holdout_rmse_percent_of_range <= OF_TREES * TREES[name]
    assert all(
        best.holdout_rmse_percent_of_range < each.holdout_rmse_percent_of_range for each in others
    )
