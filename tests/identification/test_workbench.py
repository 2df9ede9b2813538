import math

import numpy as np
import pytest

from opensuction.hysteresis.modified_dahl import PUBLISHED, simulate
from opensuction.identification.workbench import Labels, compare, identify
from opensuction.kernel.errors import InputError

HEAD = 50.0 * (1.0 - np.cos(np.linspace(0.0, 8.0 * math.pi, 1200)))
TIP = simulate(PUBLISHED, HEAD, 2.0)


def test_the_second_half_is_predicted_not_fitted() -> None:
    spoilt = TIP.copy()
    spoilt[600:] += 3.0
    found = identify(HEAD, spoilt, holdout_ratio=0.5)
    assert found.fitted_samples == 600
    assert found.fitted == pytest.approx(TIP, abs=1e-6)
    assert found.rmse == pytest.approx(0.0, abs=1e-6)
    percent = 100.0 * 3.0 / float(np.ptp(spoilt))
    assert found.holdout_rmse_percent_of_range == pytest.approx(percent, rel=1e-6)


def test_nothing_held_out_has_no_holdout_score() -> None:
    found = identify(HEAD, TIP)
    assert math.isnan(found.holdout_rmse_percent_of_range)
    assert found.fitted_samples == found.samples == 1200


def test_units_are_the_callers() -> None:
    labels = Labels("spindle_deg", "jaw_deg", "deg", "counts")
    found = identify(HEAD, TIP, labels=labels)
    assert found.parameters["slope"].unit == "counts/deg"
    assert found.parameters["offset"].unit == "counts"
    with pytest.raises(InputError, match=r"spindle_deg has 1200 samples, jaw_deg 1199"):
        identify(HEAD, TIP[:-1], labels=labels)


def test_one_of_the_compared_models_is_recommended() -> None:
    told = []
    results = compare(HEAD, TIP, progress=lambda *step: told.append(step))
    assert [result.recommended for result in results].count(True) == 1
    assert len(told) == len(results)


@pytest.mark.parametrize(
    ("model", "method", "holdout_ratio", "says"),
    [
        ("dahll", None, 0.0, "model 'dahll' is not known: one of "),
        ("modified-dahl", "luck", 0.0, "method 'luck' is not known: one of "),
        ("modified-dahl", None, 0.95, "holdout 0.95: should be from 0 to 0.9"),
        ("modified-dahl", None, math.nan, "holdout nan"),
    ],
)
def test_impossible_choices_are_refused_in_one_line(
    model: str, method: str | None, holdout_ratio: float, says: str
) -> None:
    with pytest.raises(InputError, match=says) as refused:
        identify(HEAD, TIP, None, model, method, holdout_ratio)
    assert "\n" not in str(refused.value)
