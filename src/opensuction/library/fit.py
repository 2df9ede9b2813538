"""A fitted model as a script has it: its figures; it predicts, inverts, draws and saves."""

import os
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from opensuction.hysteresis.named_model import Model, to_targets
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.library.columns import Values, read_inputs, to_row
from opensuction.library.drawing import Curve, draw
from opensuction.result.identification_result import IdentificationResult, ModelResult
from opensuction.result.plain import Json, to_json
from opensuction.settings import identification_file
from opensuction.settings.identification_file import Identified, IdentifiedParameter
from opensuction.settings.model_structure import ModelPart

SHOWN = 8
"""Parameters that are shown of those that a model has."""
SWEEP = 400
"""Samples of a stroke that is drawn where the recording is not there."""


class Parameters(dict[str, IdentifiedParameter]):
    """Parameters by name; each has a ``value``, a ``unit`` and ``ci95``, empty where not known."""

    def __repr__(self) -> str:
        lines = [
            f"{name} = {one.value:.6g} {one.unit}{_interval(one)}"
            for name, one in list(self.items())[:SHOWN]
        ]
        more = [f"... {len(self) - SHOWN} more"] if len(self) > SHOWN else []
        return "\n".join(lines + more)


def _interval(one: IdentifiedParameter) -> str:
    return f" ({one.ci95[0]:.6g} to {one.ci95[1]:.6g})" if one.ci95 else ""


class Fitted(NamedTuple):
    """The recording of a fit, its output as the model has it."""

    driven: Array
    """The first input."""
    answer: Array
    fitted: Array


class LoadedResult(NamedTuple):
    """Result of ``identify``, as a parameter file holds it."""

    model: str
    method: str
    parameters: Mapping[str, IdentifiedParameter]
    rmse: float
    rmse_unit: str
    rmse_percent_of_range: float
    well_posed: bool
    samples: int
    fitted_samples: int
    parameter_file: str


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """A model fitted to a recording; `identify`, `compare` and `load` make one."""

    identified: Identified
    """What its parameter file holds."""
    result: IdentificationResult | LoadedResult
    """What its figures are read from."""
    recording: Fitted | None = None
    """None for a file that was loaded: it has no samples in it."""

    def __getstate__(self) -> dict[str, Any]:
        """The fields alone, for pickles: what is derived from them holds functions."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def summary(self) -> Json:
        """The object of ``opensuction identify --json``; of a file that was loaded, its part."""
        return to_json(self.result)

    @property
    def _model_result(self) -> ModelResult | None:
        """Errors and warnings; None for a file that was loaded."""
        return self.result.fit if isinstance(self.result, IdentificationResult) else None

    @property
    def model(self) -> str:
        """Name of the model, one of ``opensuction.hysteresis.CATALOGUE``."""
        return self.identified.about.model

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs, in their order."""
        return identification_file.input_names(self.identified)

    @property
    def parameters(self) -> Parameters:
        """Parameters by name, each with value, unit and 95 % interval."""
        return Parameters(self.identified.parameters)

    @property
    def rmse(self) -> float:
        """Root mean square residual of the fitted samples, in the output's unit."""
        return self.identified.about.rmse

    @property
    def holdout_rmse_percent_of_range(self) -> float | None:
        """Of the samples held out, in percent of the output's range; None without any."""
        found = self._model_result
        return None if found is None else found.holdout_rmse_percent_of_range

    @property
    def warnings(self) -> tuple[str, ...]:
        """Weaknesses of recording and fit, a sentence each; a file holds none."""
        found = self._model_result
        return () if found is None else found.warnings

    @property
    def is_invertible(self) -> bool:
        """True if `inverse` need not jump."""
        return self.identified.about.well_posed

    @cached_property
    def _parts(self) -> tuple[ModelPart, ...]:
        return identification_file.to_model(self.identified, self.model)

    @property
    def _sign(self) -> float:
        """Of the output as it was given, over that of the output as it was fitted."""
        return identification_file.output_sign(self.identified)

    @property
    def hysteresis(self) -> Model:
        """The model by itself, as ``opensuction.hysteresis.model`` makes one.

        Its output is not negated. Raises InputError for a model of several inputs.
        """
        if len(self._parts) > 1:
            raise InputError(
                f"model '{self.model}' follows {len(self._parts)} inputs "
                f"({', '.join(self.inputs)}); an inverse is of one: identify it from one input"
            )
        part = self._parts[0]
        return Model(self.model, part.record, part.offset)

    def predict(self, x: Values, past: float | None = None, start: float | None = None) -> Array:
        """Output of the model for inputs of any length.

        x: shape (n,), of several inputs (n, inputs) or a data frame of them. past: before the
        first sample, from -1 (after a long retract) to +1 (after a long advance); None: what the
        fitted recording began after. start: where the input was after that past; None: at the
        first sample. Returns shape (n,), in the unit of the output that was given.
        Raises InputError for what is no row of numbers.
        """
        inputs = read_inputs(x, len(self._parts))
        if past is not None:
            return self._sign * self._simulate(
                inputs, lambda row, model: model.simulate(row, past, start)
            )
        if start is not None:
            raise InputError("start: says where the input was after a past; give past= too")
        return identification_file.predict(self.identified, self._parts, inputs)

    @property
    def residuals(self) -> Array:
        """Given minus fitted output of the recording, those held out included, shape (n,).

        Raises InputError for a file that was loaded: it has no samples in it.
        """
        if self.recording is None:
            raise InputError("residuals: a parameter file has no samples; predict a recording")
        return self._sign * (self.recording.answer - self.recording.fitted)

    def score(self, x: Values, y: ArrayLike) -> float:
        """Share of the output's variance that `predict` of the inputs explains, at most 1.

        The coefficient of determination, as scikit-learn's regressors have it: 0 is as good as
        the mean, below 0 is worse. Raises InputError for what is no row of numbers, and for an
        output that does not move or has another length.
        """
        predicted, measured = self.predict(x), to_row("y", y)
        if measured.size != predicted.size:
            raise InputError(f"x has {predicted.size} samples, y has {measured.size}; give as many")
        spread = measured - measured.mean()
        if not spread.any():
            raise InputError("y: does not move, so no share of it can be explained")
        rest = measured - predicted
        return float(1.0 - (rest @ rest) / (spread @ spread))

    def _simulate(self, inputs: Array, run: Callable[[Array, Model], Array]) -> Array:
        """The sum of what each input's part gives."""
        output = np.zeros(inputs.shape[1])
        for part, row in zip(self._parts, inputs, strict=True):
            output += run(row, Model(self.model, part.record, part.offset))
        return output

    def inverse(
        self, y: ArrayLike, past: float = -1.0, start: float | None = None, jumps: bool = False
    ) -> Array:
        """Inputs that make the model's output run through ``y``, each from the one before.

        y: shape (n,), as the output was given. past: before the first of them, from -1 (after a
        long retract) to +1. start: where the input is after that; None: at the end of the
        recorded range that it came to. jumps: let the input jump across a gap, where the model is
        not invertible without. Returns shape (n,); ``predict`` of it with the same past and start
        is y. Raises InputError for a model that is not invertible, with the reason, and for
        outputs that no input reaches.
        """
        span = self.identified.about.recording.input
        usual = span.highest if past > 0.0 else span.lowest
        targets = self._sign * to_targets(y)
        at = usual if start is None else start
        return self.hysteresis.inverse(targets, past, at, jumps)

    def plot(self, ax: Any = None) -> Any:
        """The recorded loop and the model's; a notebook shows it.

        ax: axes of matplotlib to draw into; they are returned. None: a `Drawing` of our own, for
        which nothing has to be installed.
        """
        curves, labels = self._curves(), self._labels()
        if ax is None:
            return draw(str(self), labels, curves)
        for curve in curves:
            ax.plot(curve.x, curve.y, label=curve.label)
        ax.set_xlabel(labels[0])
        ax.set_ylabel(labels[1])
        ax.legend()
        return ax

    def _curves(self) -> list[Curve]:
        if self.recording is not None:
            driven, answer, fitted = self.recording
            return [
                Curve("recording", driven, self._sign * answer),
                Curve(self.model, driven, self._sign * fitted),
            ]
        span = self.identified.about.recording.input
        rise = np.linspace(span.lowest, span.highest, SWEEP)
        stroke = np.concatenate([rise, rise[::-1], rise])
        return [Curve(self.model, stroke, self._sign * self.hysteresis.simulate(stroke))]

    def _labels(self) -> tuple[str, str]:
        found = self.identified.about.recording
        axes = ((one.column, one.unit) for one in (found.input, found.output))
        across, up = (f"{name} ({unit})" if unit else name for name, unit in axes)
        return across, up

    def save(self, path: str | PathLike[str]) -> None:
        """Write the parameter file, which ``load`` and ``cycle --compensation`` take.

        path: ends in ``.toml``; a file that is there is replaced. Raises InputError for another
        ending, OSError where the file cannot be written.
        """
        file = Path(path)
        if file.suffix != ".toml":
            raise InputError(f"{file}: a parameter file is TOML; give a name that ends in .toml")
        _replace(file, identification_file.to_toml(self.identified))

    def __repr__(self) -> str:
        about = self.identified.about
        unit = "" if about.rmse_unit == "output" else f" {about.rmse_unit}"
        return (
            f"Fit({about.model}, rmse {about.rmse:.3g}{unit} "
            f"({about.rmse_percent_of_range:.3g} % of range), {about.recording.samples} samples)"
        )

    def _repr_html_(self) -> str:
        """The fit as a notebook shows it: figures, parameters, loop."""
        rows = "".join(
            f"<tr><td>{escape(name)}</td><td>{one.value:.6g}</td><td>{escape(one.unit)}</td>"
            f"<td>{escape(_interval(one))}</td></tr>"
            for name, one in list(self.parameters.items())[:SHOWN]
        )
        said = "".join(f"<p>{escape(one)}</p>" for one in self.warnings)
        drawn = self.plot().svg if self.recording is not None or len(self.inputs) == 1 else ""
        return f"<p><b>{escape(repr(self))}</b></p>{said}<table>{rows}</table>{drawn}"


def _replace(file: Path, text: str) -> None:
    """Write a file aside and put it in place whole."""
    handle, name = tempfile.mkstemp(prefix=f".{file.name}-", dir=file.parent)
    aside = Path(name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            stream.write(text)
        private_file.share(aside)
        aside.replace(file)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


def load(path: str | PathLike[str]) -> Fit:
    """The fit of a parameter file that ``Fit.save``, ``identify`` or ``compare`` wrote.

    It predicts what the fit before it did, to the last bit; samples and warnings are not in it.
    Raises InputError for what is no such file.
    """
    file = Path(path)
    identified = identification_file.load(file)
    identification_file.to_model(identified, file)
    about = identified.about
    held = LoadedResult(
        model=about.model,
        method=about.method,
        parameters=identified.parameters,
        rmse=about.rmse,
        rmse_unit=about.rmse_unit,
        rmse_percent_of_range=about.rmse_percent_of_range,
        well_posed=about.well_posed,
        samples=about.recording.samples,
        fitted_samples=about.recording.fitted_samples,
        parameter_file=str(file),
    )
    return Fit(identified, held)
