"""Result of a calibration: verdict, checks, identified models, and the choice among them."""

from collections.abc import Mapping
from typing import Annotated, Literal, NamedTuple

from opensuction.result.identification_result import FittedParameter, PlaysModel
from opensuction.result.plain import FLAT, IF_FINITE


class FeedforwardEstimate(NamedTuple):
    """Feedforward of the insertion servo."""

    velocity_v_s_per_mm: float
    friction_v: float
    rmse_v: float
    """Voltage left unexplained."""
    samples: int
    """That were fast enough and not saturated."""


class ValidationErrors(NamedTuple):
    """Errors on the second run, to which nothing was fitted; all root mean square."""

    model_rmse_mm: float
    """Of the modified Dahl model."""
    model_percent_of_range: float
    plays_rmse_mm: float
    plays_percent_of_range: float
    repeatability_mm: float
    """Tip of the second run less tip of the first."""
    servo_rmse_v: float
    """Of the feedforward, in the first run."""
    range_mm: float
    """Of the tip in the second run."""


class IdentifiedModels(NamedTuple):
    """Models and servo feedforward that the recording determined."""

    model: Literal["modified-dahl"]
    """Hysteresis model whose parameters these are."""
    parameters: Mapping[str, FittedParameter]
    """Of that model, by name."""
    plays: PlaysModel
    servo: FeedforwardEstimate
    gap_mm: float
    """Of the modified Dahl model: lag of the tip behind the head at a reversal."""
    gap_ratio: float
    """Gap over the machine's nominal one."""
    rmse_mm: float
    """Of the modified Dahl model in the first run, to which it was fitted."""
    plays_rmse_mm: float
    """Of the plays in the first run."""
    validation_rmse_mm: float
    """Of the modified Dahl model in the second run."""
    validation: ValidationErrors


class NoModels(NamedTuple):
    """In place of `IdentifiedModels` where the recording determined none."""

    model: None = None
    parameters: None = None
    plays: None = None
    servo: None = None
    gap_mm: None = None
    gap_ratio: None = None
    rmse_mm: None = None
    plays_rmse_mm: None = None
    validation_rmse_mm: None = None
    validation: None = None


class ModelChoice(NamedTuple):
    """Comparison of the models by which the machine can be driven."""

    model: str
    """The one with which it is driven."""
    reason: str
    """In a sentence."""
    errors_mm: Mapping[str, float]
    """Root mean square error on strokes left out, by model."""
    refused: Mapping[str, str]
    """Reason why a model does not drive, by model."""
    driven_model: str | None
    """The best of the models of plays with lines; None where none drives."""
    driven_rmse_mm: float | None
    """Its root mean square error in the second run."""


class CheckedBound(NamedTuple):
    """A bound of a calibration, and the value that was held against it."""

    name: str
    value: Annotated[float, IF_FINITE]
    """What is no number (nan) keeps no bound."""
    least: float | None
    most: float | None
    unit: str
    remedy: str
    ok: bool
    """Whether the bound is kept."""
    bound: str
    """In words."""


class CalibrationResult(NamedTuple):
    """Result of a calibration, accepted or not."""

    accepted: bool
    reasons: tuple[str, ...]
    """Of the refusal, in sentences; empty where it is accepted."""
    machine: str
    patient: str | None
    """For whom the machine is set up; None on a bench."""
    catheter_mm: float
    """Outer diameter of the catheter."""
    conduit_bend_rad: float
    seed: int
    compensation: str
    """The compensator that the parameter file names."""
    choice: ModelChoice | None
    """None where one compensator was asked for that needs no comparison, or none was reached."""
    in_silico: bool
    models: Annotated[IdentifiedModels | NoModels, FLAT]
    checks: tuple[CheckedBound, ...]
    samples: int
    """Of the recording, of which the file keeps each tenth."""
    recording_sha256: str
    parameter_file: str | None
    """Its path; None where none was written."""
    version: str
    """Of the software."""
    date_utc: str
    seconds: float
    """Duration of the command."""

    @property
    def identified(self) -> IdentifiedModels | None:
        """The models; None where the recording determined none."""
        return self.models if isinstance(self.models, IdentifiedModels) else None
