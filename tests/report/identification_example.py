"""A made-up comparison for the tests of the report: closed-form curves, nothing is fitted."""

from typing import Any

import numpy as np
import numpy.typing as npt

from opensuction.report.identification.identification_series import FittedCurves

SAMPLES = 4000
FITTED = 2800
MODELS = ("modified-dahl", "prandtl-ishlinskii", "bouc-wen")

Array = npt.NDArray[np.float64]


def curves(
    models: tuple[str, ...] = MODELS, samples: int = SAMPLES, timed: bool = True
) -> FittedCurves:
    """Four cycles of a loop; each model misses it in a way of its own."""
    phase = np.linspace(0.0, 8.0 * np.pi, samples)
    driven = 50.0 - 50.0 * np.cos(phase)
    answer = 0.95 * driven - 6.0 - 9.0 * np.sin(phase)
    fitted = {
        name: answer - (0.4 + 0.3 * place) * np.sin((3 + place) * phase)
        for place, name in enumerate(models)
    }
    lags = np.arange(200.0)
    return FittedCurves(
        time_s=0.01 * np.arange(samples, dtype=np.float64) if timed else None,
        driven=driven,
        answer=answer,
        fitted=fitted,
        autocorrelation={name: np.exp(-lags / 40.0) * np.cos(lags / 15.0) for name in models},
        fitted_samples=samples * FITTED // SAMPLES,
    )


def model(name: str, place: int = 0, **changes: Any) -> dict[str, Any]:
    """One model of a summary, with keys replaced."""
    complete: dict[str, Any] = {
        "model": name,
        "model_words": "straight line plus a Dahl state",
        "method": "variable-projection",
        "parameters": {
            "slope": {"value": 0.95 + 0.01 * place, "unit": "mm/mm", "ci95": [0.93, 0.99]},
            "velocity_gain": {"value": 0.8, "unit": "mm/mm", "ci95": [0.78, 0.83]},
            "decay": {"value": 0.08, "unit": "1/mm", "ci95": [0.077, 0.0834]},
            "offset": {"value": -6.0, "unit": "mm", "ci95": None},
        },
        "rmse": 0.3 + 0.2 * place,
        "rmse_unit": "mm",
        "rmse_percent_of_range": 0.3 + 0.2 * place,
        "holdout_rmse_percent_of_range": 0.4 + 0.2 * place,
        "cross_validation_percent_of_range": 0.35 + 0.2 * place,
        "well_posed": place > 0,
        "recommended": place == 0,
        "warnings": ["the residual is not noise: neighbouring samples are alike (r = 0.97)"],
        "samples": SAMPLES,
        "fitted_samples": FITTED,
        "parameter_file": f"runs/{name}.toml",
    }
    return complete | changes


def provenance() -> dict[str, Any]:
    return {
        "recording": {
            "file": "bench.csv",
            "sha256": "0123456789abcdef" * 4,
            "samples": SAMPLES,
            "input": {"column": "head_mm", "unit": "mm", "negated": False},
            "output": {"column": "tip_mm", "unit": "mm", "negated": False},
            "time": "time_s",
        },
        "holdout_ratio": 0.3,
        "line_rmse_percent_of_range": 9.8,
        "version": "0.1.0",
        "date_utc": "2026-11-21T12:00:00+00:00",
        "seconds": 1.5,
    }


def compared(**changes: Any) -> dict[str, Any]:
    """The object of ``compare``, with top-level keys replaced."""
    models = [model(name, place) for place, name in enumerate(MODELS)]
    return {"models": models} | provenance() | changes


def identified(**changes: Any) -> dict[str, Any]:
    """The object of ``identify``, with keys replaced."""
    return model(MODELS[0], recommended=False) | provenance() | changes
