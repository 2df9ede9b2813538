"""Models of the leaderboard by name, and estimators of others."""

from pathlib import Path

import numpy as np
import pytest

from opensuction.evidence.leaderboard import contender, data_set
from opensuction.kernel.errors import InputError
from tests.evidence.leaderboard.data_set_example import LINE, line

MODULE = """
import numpy as np

class Line:
    def __init__(self, slope=2.0):
        self.slope = slope
    def fit(self, X, y):
        self.offset = float(np.mean(y - self.slope * X[:, 0]))
    def predict(self, X):
        return self.slope * X[:, :1] + self.offset

class Steeper(Line):
    def __init__(self, slope):
        super().__init__(slope)

STEEPER = Steeper(3.0)
NUMBER = 4
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a module of the user's in it."""
    (tmp_path / "leaderboard_of_mine.py").write_text(MODULE)
    (tmp_path / "leaderboard_broken.py").write_text("1 / 0")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder")
def test_a_class_and_an_object_of_a_module_in_the_current_folder() -> None:
    samples = data_set.cut(LINE, line())
    chosen = contender.select(("leaderboard_of_mine:Line", "leaderboard_of_mine:STEEPER"))
    flat, steep = (one.predict(samples) for one in chosen)
    np.testing.assert_allclose(flat, 2.0 * samples.inputs[0] + 1.0)
    np.testing.assert_allclose(np.ptp(steep) / np.ptp(samples.inputs[0]), 3.0)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("leaderboard_of_mine:None", "leaderboard_of_mine has no None"),
        ("leaderboard_of_mine:NUMBER", "has no fit and no predict"),
        ("leaderboard_of_mine:Steeper", "cannot be made without arguments"),
        ("leaderboard_broken:Line", "cannot be imported (ZeroDivisionError"),
        ("no.such.module:Line", "cannot be imported (ModuleNotFoundError"),
        (":Line", "cannot be imported"),
        ("maxwell-slop", "did you mean 'maxwell-slip'"),
    ],
)
def test_what_is_no_model(name: str, expected: str) -> None:
    with pytest.raises(InputError) as refused:
        contender.select((name,))
    assert expected.lower() in str(refused.value).lower()
    assert "\n" not in str(refused.value)


def test_an_estimator_that_answers_something_else_is_refused() -> None:
    class Short:
        def fit(self, *_: object) -> None:
            """Nothing."""

        def predict(self, _: object) -> list[float]:
            """One sample."""
            return [1.0]

    (chosen,) = contender.select((Short(),))
    with pytest.raises(InputError, match="predicts 1 samples of 400 rows"):
        chosen.predict(data_set.cut(LINE, line()))


def test_estimators_of_one_class_keep_apart() -> None:
    linear = pytest.importorskip("sklearn.linear_model")
    chosen = contender.select((linear.LinearRegression(), linear.LinearRegression()))
    assert [one.name for one in chosen] == ["LinearRegression", "LinearRegression 2"]
    samples = data_set.cut(LINE, line())
    straight = contender.BUILT_IN["straight-line"].predict(samples)
    np.testing.assert_allclose(chosen[0].predict(samples), straight, atol=1e-9)


def test_our_regressor_by_name_is_the_model_of_the_catalogue() -> None:
    pytest.importorskip("sklearn")
    (chosen,) = contender.select(("opensuction.sklearn:HysteresisRegressor",))
    samples = data_set.cut(LINE, line())
    catalogue = contender.BUILT_IN["modified-dahl"].predict(samples)
    np.testing.assert_allclose(chosen.predict(samples), catalogue, atol=1e-9)


@pytest.mark.parametrize("name", [contender.DAMPER, contender.OSCILLATOR])
def test_a_grey_box_takes_its_own_quantities_alone(name: str) -> None:
    assert not contender.BUILT_IN[name].takes(data_set.cut(LINE, line()))
