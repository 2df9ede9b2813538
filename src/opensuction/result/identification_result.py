"""Results of ``identify`` and ``compare``, and the model that a cycle compensated with.

Field names are the keys of the JSON objects (docs/reference/results.md). A computed number is None
where there is nothing to compute it from, or where it is not finite.
"""

from collections.abc import Mapping
from typing import Annotated, NamedTuple

from opensuction.result.plain import FLAT, IF_KNOWN


class FittedParameter(NamedTuple):
    """A parameter of a model, and the interval that holds the true value with 95 % confidence."""

    value: float | None
    unit: str
    ci95: tuple[float, float] | None
    """Lower and upper end; None where no interval can be given."""


class InputRange(NamedTuple):
    """Inputs that a model was fitted to, in their unit, and their mean speeds from turn to turn."""

    lowest: float | None
    highest: float | None
    slowest: float | None
    """Of the slowest stroke, in the input's unit a second; None where no times are known."""
    fastest: float | None
    """Likewise, of the fastest."""


class ModelResult(NamedTuple):
    """One model fitted to a recording: parameters, errors, and what it can be used for.

    An error in percent is root mean square, of the range of the whole output.
    """

    model: str
    """Name in the catalogue of hysteresis models."""
    model_words: str
    """The model in a few words."""
    method: str
    method_words: str
    """The method in a few words."""
    parameters: Mapping[str, FittedParameter]
    """By their names, each in the unit that the columns of the recording give it."""
    rmse: float | None
    """Of the fitted samples, in the unit of the output."""
    rmse_unit: str
    """``output`` where the unit of the output is not known."""
    rmse_percent_of_range: float | None
    holdout_rmse_percent_of_range: float | None
    """Of the samples held out; None without any."""
    cross_validation_percent_of_range: float | None
    """Of blocks of the fitted samples, each predicted from the others."""
    well_posed: bool
    """Whether the model has a continuous inverse."""
    determined: bool
    """Whether the parameters mean something: no other memory fits as well, and most of the output
    is explained."""
    transfer_percent_of_range: float | None
    """Of two parts of the fitted samples, each predicted from the other alone."""
    effective_parameters: float | None
    """How many parameters a fit without penalty would need to do as much."""
    recommended: bool
    """Whether the comparison recommends this model; False where nothing was compared."""
    reasons: tuple[str, ...]
    """Why it is recommended, a sentence each."""
    coupling_percent_of_range: Mapping[str, float] | None
    """What each of several inputs adds, root mean square about its mean, by column; None of one."""
    warnings: tuple[str, ...]
    """Weak points of recording and fit, a sentence each."""
    at_bound: tuple[str, ...]
    """Parameters, or elements of a grid, that a bound of the search holds."""
    samples: int
    """Of the recording, those held out included."""
    fitted_samples: int
    fitted_range: InputRange
    fit_seconds: float | None
    """Processor time of the fit alone; None where there was no time left to measure it, and in the
    library, which does each fit once."""
    inverse: str
    """How the model is inverted, in words; begins with ``none`` where it only predicts."""
    compensator: str | None
    """The compensator that takes the model; None where it drives no head."""
    undriven: str | None
    """Why no compensator takes the model; None where one does."""
    parameter_file: str | None
    """Path of the file with the parameters; None where none was written."""


class RecordedColumn(NamedTuple):
    """A column of a recording as it was used."""

    column: str
    unit: str
    """Empty where it is not known."""
    negated: bool
    lowest: float | None
    highest: float | None


class IdentifiedRecording(NamedTuple):
    """The recording that models were fitted to, as far as it was used."""

    file: str
    """Its name without folders."""
    sha256: str
    size_bytes: int
    samples: int
    skipped_rows: int
    """Left out, for a number is missing in them."""
    from_s: float | None
    """Of the first sample; None where no times are known."""
    to_s: float | None
    """Likewise, of the last."""
    input: RecordedColumn
    """The first input."""
    other_inputs: tuple[str, ...]
    """Names of the columns of the others."""
    output: RecordedColumn
    time: str | None
    """Name of the column of times."""


class Provenance(NamedTuple):
    """Recording and software that a result rests on, and the error of a straight line."""

    recording: IdentifiedRecording
    holdout_ratio: float
    """Share of the recording, from its end, that was predicted instead of fitted."""
    line_rmse_percent_of_range: float | None
    """What a straight line leaves, which any model has to beat."""
    version: str
    date_utc: str
    """In the format of ISO 8601."""
    seconds: float
    """That the whole command took once the recording was read."""


class IdentificationResult(NamedTuple):
    """One model fitted to a recording."""

    fit: Annotated[ModelResult, FLAT]
    provenance: Annotated[Provenance, FLAT]

    @property
    def models(self) -> tuple[ModelResult, ...]:
        """The model alone, as a comparison has several."""
        return (self.fit,)


class ComparisonResult(NamedTuple):
    """Every model fitted to the same recording."""

    models: tuple[ModelResult, ...]
    """The recommended one first, the others by their error for the purpose."""
    left_out: Mapping[str, str]
    """Models that this recording does not identify, each with the reason."""
    provenance: Annotated[Provenance, FLAT]


class PredictionError(NamedTuple):
    """Measured minus predicted output, of all samples."""

    rmse: float
    """Root mean square, in the unit of the output."""
    rmse_percent_of_range: float | None
    """Of the measured range; None where the measured output does not move."""
    mean: float
    """In the unit of the output: a constant offset between recording and model."""
    largest: float
    """Of the absolute values, in the unit of the output."""
    inside_interval_ratio: float | None
    """Share of the samples that lie inside the interval; None without one."""


class PredictionResult(NamedTuple):
    """Output that a model predicts for the inputs of a recording."""

    model: str
    """Name in the catalogue of hysteresis models."""
    parameter_file: str
    file: str
    """Name of the recording without folders."""
    sha256: str
    """Of the recording."""
    samples: int
    skipped_rows: int
    """Left out, for a number is missing in them."""
    inputs: tuple[str, ...]
    """Names of the columns."""
    output: str | None
    """Column that the prediction is held against; None: the recording has none."""
    unit: str
    """Of the output; ``output`` where it is not known."""
    lowest: float
    highest: float
    """Of the predicted values."""
    beyond_range: int
    """Samples whose first input lies outside of what the model was fitted to."""
    interval_half_width: float | None
    """Added to and taken from each predicted value it gives the 95 % interval; None without."""
    error: PredictionError | None
    """None where there is nothing to hold the prediction against."""
    warnings: tuple[str, ...]
    """Sentences."""
    version: str
    date_utc: str
    """In the format of ISO 8601."""
    prediction_file: str
    """Path of the table: a row for each sample."""


WorkbenchResult = IdentificationResult | ComparisonResult
"""Of ``identify`` or of ``compare``."""


class PlaysModel(NamedTuple):
    """Plays that `prandtl-ishlinskii` and `preview` work with."""

    thresholds_mm: list[float]
    weights: list[float]
    slope: float
    offset_mm: float
    curvature_per_mm: float
    gap_mm: float
    rmse_mm: Annotated[float | None, IF_KNOWN] = None
    well_posed: Annotated[bool | None, IF_KNOWN] = None


class TransmissionModel(NamedTuple):
    """Model of the transmission that the compensator worked with, and its source."""

    model: str
    slope: float
    velocity_gain: float
    decay_per_mm: float
    offset_mm: float
    gap_mm: float
    rmse_mm: float | None
    well_posed: bool
    driven_model: str | None
    samples: int | None
    feedforward_v_s_per_mm: float
    friction_v: float
    file: str | None
    recording: str | None
    recording_sha256: str | None
    plays: Annotated[PlaysModel | None, IF_KNOWN] = None
