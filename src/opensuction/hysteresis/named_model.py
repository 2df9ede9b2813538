"""A model of the catalogue together with its numbers, and one way to call it, whichever it is.

For scripts and notebooks; the control core uses each model's own module.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from opensuction.hysteresis.catalogue import hysteresis_model
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    LinearForm,
    Ranges,
    Record,
    VectorForm,
)
from opensuction.hysteresis.play import Play
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

WITHOUT_FORM: dict[str, Any] = {"play": Play(0.0, 1.0, 0.0)}
"""An example of the record of each model that no recording identifies."""


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """A hysteresis model with its numbers; `model` makes one."""

    name: str
    """Of the catalogue."""
    record: Record
    """Its parameters, as the model's own module has them."""
    offset: float = 0.0
    """Added to every output; for a model that has no offset of its own."""

    @property
    def entry(self) -> HysteresisModel:
        """Catalogue entry of the model: title, source, what it cannot represent."""
        return CATALOGUE[self.name]

    @property
    def is_invertible(self) -> bool:
        """True where the output follows the input at once, so that `inverse` need not jump."""
        return bool(self.entry.is_monotone(self.record))

    def simulate(self, x: ArrayLike, past: float = -1.0, start: float | None = None) -> Array:
        """Output for a row of inputs.

        x: shape (n,). past: before the first sample, from -1 (after a long retract) over 0
        (relaxed) to +1 (after a long advance). start: where the input was after that past, from
        where it goes to the first sample; None: there already. Returns shape (n,).
        Raises InputError for what is no row of numbers, and parameters that make no model.
        """
        if not -1.0 <= past <= 1.0:
            raise InputError(
                f"past: {past:g}, should be from -1 (after a long retract) to 1 (after a long "
                "advance)"
            )
        inputs = np.asarray(x, dtype=np.float64)
        if start is None:
            return hysteresis_model.simulate(self.entry, self.record, inputs, past) + self.offset
        moved = np.append(start, inputs) if inputs.ndim == 1 and inputs.size else inputs
        return hysteresis_model.simulate(self.entry, self.record, moved, past)[1:] + self.offset

    def inverse(
        self, y: ArrayLike, past: float = -1.0, start: float = 0.0, jumps: bool = False
    ) -> Array:
        """Inputs that make the output run through a row of targets, each from the one before.

        y: shape (n,). past, start: as `simulate` takes them. jumps: let the input jump across a
        gap, where the output stands still or first moves the wrong way after a reversal. Returns
        shape (n,). Raises InputError for a model that only predicts, for one that is not
        invertible, unless it may jump, and for a target that no input reaches.
        """
        targets = to_targets(y)
        self.simulate([start], past)  # refuses what is no past, and what is no model
        if not self.entry.has_inverse:
            raise InputError(
                f"model '{self.name}' has no inverse: {self.entry.undriven}; take modified-dahl, "
                "or a model of plays"
            )
        if not (self.is_invertible or jumps):
            raise InputError(
                f"model '{self.name}' has no continuous inverse: with these parameters its output "
                "stands still or moves the wrong way after a reversal; give jumps=True to cross "
                "that as a gap, or take a model whose output always follows"
            )
        state = hysteresis_model.start(self.entry, self.record, start, past)
        found, reached = hysteresis_model.invert(
            self.entry, self.record, state, targets - self.offset
        )
        if not reached.all():
            first = int(np.argmin(reached))
            raise InputError(
                f"y: sample {first} is {targets[first]:g}, which no input of model '{self.name}' "
                f"reaches ({np.count_nonzero(~reached)} such of {targets.size}): it lies beyond "
                "the model's range, or the model is not monotone"
            )
        return found

    def __repr__(self) -> str:
        numbers = ", ".join(f"{name}={_show(value)}" for name, value in self._fields().items())
        return f"Model({self.name}, {numbers})"

    def _fields(self) -> dict[str, Any]:
        fields: dict[str, Any] = dict(self.record._asdict())
        return fields | ({"offset": self.offset} if self.offset else {})


def to_targets(y: ArrayLike) -> Array:
    """Outputs that are wanted as a row of finite numbers; raises InputError."""
    try:
        targets = np.asarray(y, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("y: should be one row of finite numbers") from None
    if targets.ndim != 1 or not np.isfinite(targets).all():
        raise InputError("y: should be one row of finite numbers")
    return targets


def _show(value: Any) -> str:
    """A number, or how many there are."""
    array = np.asarray(value)
    return f"{float(array):.6g}" if array.ndim == 0 else f"<{array.size} numbers>"


def _example(entry: HysteresisModel) -> Record:
    """A record of a model, for the names and kinds of its fields."""
    match entry.form:
        case VectorForm():
            return entry.form.record(np.ones(len(entry.form.parameters)))
        case LinearForm():
            return entry.form.initial_guesses(Ranges(0.0, 1.0, 0.0, 1.0, 0.5))[0]
    return WITHOUT_FORM[entry.name]


def model(name: str, **parameters: ArrayLike) -> Model:
    """A model of the catalogue with these parameters.

    name: such as ``modified-dahl``; all are in `CATALOGUE`. parameters: every field of its record,
    in mm: numbers, or rows of them.

    >>> catheter = model("play", width_mm=2.0, gain=1.0, offset_mm=0.0)
    >>> catheter.simulate([0.0, 3.0, 0.0], past=1.0).tolist()
    [-1.0, 2.0, 1.0]

    Raises InputError for an unknown name, missing or surplus parameters, and values that make no
    model.
    """
    if name not in CATALOGUE:
        raise InputError(f"model '{name}' is not known: one of {', '.join(CATALOGUE)}")
    entry = CATALOGUE[name]
    example = _example(entry)
    if parameters.keys() != set(example._fields):
        raise InputError(
            f"model '{name}': given {', '.join(parameters) or 'nothing'}, should be "
            f"{', '.join(example._fields)}"
        )
    values: dict[str, Any] = {}
    for field, usual in example._asdict().items():
        try:
            array = np.asarray(parameters[field], dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"model '{name}': {field} is no number") from None
        if array.ndim != np.ndim(usual):
            kind = "one number" if np.ndim(usual) == 0 else f"an array of {np.ndim(usual)} axes"
            raise InputError(f"model '{name}': {field} has shape {array.shape}, should be {kind}")
        values[field] = float(array) if array.ndim == 0 else np.ascontiguousarray(array)
    made = Model(name, type(example)(**values))
    made.simulate([0.0])  # refuses what makes no model
    return made
