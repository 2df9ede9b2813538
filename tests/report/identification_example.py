"""A made-up comparison for the tests of the report: closed-form curves, nothing is fitted."""

from typing import Any

import numpy as np
import numpy.typing as npt

from opensuction.report.identification.identification_page import FittedCurves
from opensuction.result.identification_result import (
    ComparisonResult,
    FittedParameter,
    IdentificationResult,
    IdentifiedRecording,
    InputRange,
    ModelResult,
    Provenance,
    RecordedColumn,
)

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


def model(name: str, place: int = 0, **changes: Any) -> ModelResult:
    """One model of a result, with fields replaced."""
    complete = ModelResult(
        model=name,
        model_words="straight line plus a Dahl state",
        method="variable-projection",
        method_words="linear parameters solved within a search for the others",
        parameters={
            "slope": FittedParameter(0.95 + 0.01 * place, "mm/mm", (0.93, 0.99)),
            "velocity_gain": FittedParameter(0.8, "mm/mm", (0.78, 0.83)),
            "decay": FittedParameter(0.08, "1/mm", (0.077, 0.0834)),
            "offset": FittedParameter(-6.0, "mm", None),
        },
        rmse=0.3 + 0.2 * place,
        rmse_unit="mm",
        rmse_percent_of_range=0.3 + 0.2 * place,
        holdout_rmse_percent_of_range=0.4 + 0.2 * place,
        cross_validation_percent_of_range=0.35 + 0.2 * place,
        well_posed=place > 0,
        determined=True,
        transfer_percent_of_range=0.45 + 0.2 * place,
        effective_parameters=4.0,
        recommended=place == 0,
        reasons=(),
        coupling_percent_of_range=None,
        warnings=("the residual is not noise: neighbouring samples are alike (r = 0.97)",),
        at_bound=(),
        samples=SAMPLES,
        fitted_samples=FITTED,
        fitted_range=InputRange(0.0, 100.0, 9.0, 11.0),
        fit_seconds=0.01,
        inverse="exact, jumps at reversals",
        compensator="exact-inverse",
        undriven=None,
        parameter_file=f"runs/{name}.toml",
    )
    return complete._replace(**changes)


def provenance(**changes: Any) -> Provenance:
    """Of every result here, with fields of the recording replaced."""
    recording = IdentifiedRecording(
        file="bench.csv",
        sha256="0123456789abcdef" * 4,
        size_bytes=123456,
        samples=SAMPLES,
        skipped_rows=0,
        from_s=0.0,
        to_s=39.99,
        input=RecordedColumn("head_mm", "mm", False, 0.0, 100.0),
        other_inputs=(),
        output=RecordedColumn("tip_mm", "mm", False, -6.0, 90.0),
        time="time_s",
    )
    return Provenance(
        recording=recording._replace(**changes),
        holdout_ratio=0.3,
        line_rmse_percent_of_range=9.8,
        version="0.1.0",
        date_utc="2026-11-21T12:00:00+00:00",
        seconds=1.5,
    )


def compared(**changes: Any) -> ComparisonResult:
    """The result of ``compare``, with fields replaced."""
    models = tuple(model(name, place) for place, name in enumerate(MODELS))
    return ComparisonResult(models, {}, provenance())._replace(**changes)


def identified(**changes: Any) -> IdentificationResult:
    """The result of ``identify``, with fields of its model replaced."""
    alone = {"recommended": False} | changes
    return IdentificationResult(model(MODELS[0], **alone), provenance())
