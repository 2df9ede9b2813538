"""A model from the parameters of a file: what their names stand for, and the model that they make.

A model that is searched for says all in its parameters. Those of a superposition are the factors
of elements (plays of certain widths, cells of a grid) after a certain past; a `Structure` holds
those, so that the file gives back the very model that was fitted.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
from annotated_types import Interval

from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    LinearForm,
    Ranges,
    Record,
    VectorForm,
)
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.settings.validation import choose
from opensuction.settings.wording import unknown

MOST_FACTORS: Final = 100_000
"""Of one input; a file that asks for more is none that was fitted."""


class Structure(NamedTuple):
    """Structure behind the parameters of a superposition over one input."""

    column: str
    """The input."""
    memory_ratio: Annotated[float, Interval(ge=-1.0, le=1.0)]
    """The past before the first sample: +1 advanced, -1 retracted, 0 relaxed."""
    lowest: float
    """Of the fitted samples: percents in the names of parameters are of the input's range."""
    highest: float
    elements: dict[str, float | list[float]]
    """Fields of the model's record that say what its elements are."""
    sizes: dict[str, list[int]]
    """How many factors of each kind: the shapes of the fields that the parameters fill."""
    memory: list[float]
    """Memory at the first sample, where it is more than a ratio can say; else empty."""
    beside: list[str]
    """Parameters that are no factors: they tell elements or memory once more."""


class ModelPart(NamedTuple):
    """The part of a model that one input moves; there are several only of several inputs."""

    entry: HysteresisModel
    record: Record
    memory_ratio: float
    """The past before the first sample; not used where there is a vector, which says it."""
    offset: float
    """Beside the record's own output."""
    vector: Array | None
    """Of a model that is searched for: all of its parameters."""
    memory: Array | None = None
    """Memory at the first sample, in place of the past."""

    def simulate(self, inputs: Array) -> Array:
        """Output for a row of inputs, shape (n,), that begins after the fitted recording's past."""
        if self.vector is not None and isinstance(self.entry.form, VectorForm):
            return self.entry.form.simulate(self.vector, inputs)
        memory = self.memory
        if memory is None:
            memory = self.entry.memory(self.record, float(inputs[0]), self.memory_ratio)
        output: Array = self.entry.simulate(self.record, inputs, memory) + self.offset
        return output


class FittedPart(NamedTuple):
    """Fitted model of one input of a superposition."""

    column: str
    input_: Array
    """Fitted samples of it."""
    record: Record
    memory_ratio: float
    memory: Array | None


def describe(
    model: str, parts: Sequence[FittedPart], names: Iterable[str]
) -> tuple[Structure, ...]:
    """The structure of a fitted superposition, for each of its inputs.

    names: of all its parameters.
    """
    form = CATALOGUE[model].form
    if not isinstance(form, LinearForm):
        return ()
    found = []
    for part in parts:
        filled = _filled(form, part.record)
        fields = {
            name: np.asarray(value, dtype=np.float64)
            for name, value in part.record._asdict().items()
        }
        found.append(
            Structure(
                column=part.column,
                memory_ratio=part.memory_ratio,
                lowest=float(part.input_.min()),
                highest=float(part.input_.max()),
                elements={
                    name: value.tolist() for name, value in fields.items() if name not in filled
                },
                sizes={name: list(value.shape) for name, value in fields.items() if name in filled},
                memory=[] if part.memory is None else part.memory.tolist(),
                beside=[],
            )
        )
    known = {
        name
        for place, (part, one) in enumerate(zip(parts, found, strict=True))
        for name in _name_factors(form, part.record, one, place)
    }
    if found:
        found[0] = found[0]._replace(beside=[name for name in names if name not in known])
    return tuple(found)


def _filled(form: LinearForm, record: Record) -> set[str]:
    """Fields of a record that factors fill."""
    ranges = Ranges(0.0, 1.0, 0.0, 1.0, 0.5)
    count = len(form.parameters(record, ranges))
    nothing, one = (form.with_factors(record, np.full(count, factor)) for factor in (0.0, 1.0))
    return {
        name
        for name, empty, full in zip(record._fields, nothing, one, strict=True)
        if not np.array_equal(empty, full)
    }


def _name_factors(form: LinearForm, record: Record, one: Structure, place: int) -> list[str]:
    """Names of the factors of an input; those after the first begin with its column."""
    prefix = f"{one.column}: " if place else ""
    ranges = Ranges(one.lowest, one.highest, 0.0, 1.0, 0.5)
    return [prefix + parameter.name for parameter in form.parameters(record, ranges)]


def rebuild(
    model: str, values: Mapping[str, float], structure: Sequence[Structure]
) -> tuple[ModelPart, ...]:
    """The model of a parameter file, a part for each input.

    model: of the catalogue. values: of its parameters by their names, those of 0 left out.
    Raises InputError for a model or parameters that are not known, and for numbers that make none.
    """
    entry = choose(model, CATALOGUE, "model")
    match entry.form:
        case VectorForm():
            return (_rebuild_vector(entry, entry.form, values),)
        case LinearForm():
            return _rebuild_superposition(entry, entry.form, values, structure)
    raise InputError(f"model '{model}' is one that no recording identifies")


def _rebuild_vector(
    entry: HysteresisModel, form: VectorForm, values: Mapping[str, float]
) -> ModelPart:
    names = [parameter.name for parameter in form.parameters]
    _refuse_others(values, names)
    missing = [name for name in names if name not in values]
    if missing:
        raise InputError(f"parameters.{missing[0]} is missing; identify again")
    vector = np.array([values[name] for name in names])
    record = _check(entry, form.record(vector))
    # Where the memory is 0 the record's output may lack an offset: a force has none of its own.
    at, relaxed = np.zeros(1), np.append(vector[:-1], 0.0)
    without = entry.simulate(record, at, entry.memory(record, 0.0, 0.0))
    offset = float((form.simulate(relaxed, at) - without)[0])
    return ModelPart(entry, record, 0.0, offset, vector)


def _rebuild_superposition(
    entry: HysteresisModel,
    form: LinearForm,
    values: Mapping[str, float],
    structure: Sequence[Structure],
) -> tuple[ModelPart, ...]:
    if not structure:
        raise InputError(
            f"has no section structure, without which the parameters of '{entry.name}' cannot be "
            "put together: it was written by an older version; identify again"
        )
    parts, known = [], list[str]()
    for place, one in enumerate(structure):
        empty = _empty(form, one)
        names = _name_factors(form, empty, one, place)
        factors = np.array([values.get(name, 0.0) for name in names])
        record = _check(entry, form.with_factors(empty, factors))
        memory = _read_memory(entry, record, one)
        parts.append(ModelPart(entry, record, one.memory_ratio, 0.0, None, memory))
        known += [*names, *one.beside]
    _refuse_others(values, known)
    return tuple(parts)


def _read_memory(entry: HysteresisModel, record: Record, one: Structure) -> Array | None:
    """The memory at the first sample. Raises InputError for one of another length."""
    if not one.memory:
        return None
    usual = np.shape(entry.memory(record, one.lowest, 0.0))
    if usual != (len(one.memory),):
        raise InputError(
            f"structure.memory has {len(one.memory)} numbers, the model's has shape {usual}; "
            "identify again"
        )
    return np.array(one.memory, dtype=np.float64)


def _empty(form: LinearForm, one: Structure) -> Record:
    """The record with its elements, and every factor 0. Raises InputError."""
    example = form.initial_guesses(Ranges(0.0, 1.0, 0.0, 1.0, 0.5))[0]
    usually, fields = _filled(form, example), dict[str, Any]()
    for name, usual in example._asdict().items():
        # The file says what its factors fill: those of slow states where the example has none.
        kind = "sizes" if name in one.sizes else "elements"
        if name not in one.sizes and name not in one.elements:
            kind = "sizes" if name in usually else "elements"
            raise InputError(f"structure.{kind}.{name} is missing; identify again")
        value = np.zeros(_shape(one.sizes[name], name)) if kind == "sizes" else one.elements[name]
        fields[name] = np.asarray(value, dtype=np.float64)
        if np.ndim(usual) != fields[name].ndim:
            raise InputError(
                f"structure.{kind}.{name} has {fields[name].ndim} dimensions, should have "
                f"{np.ndim(usual)}; identify again"
            )
        if np.ndim(usual) == 0:
            fields[name] = float(fields[name])
    if not one.highest > one.lowest:
        raise InputError(f"structure.highest is {one.highest:g}, should be above structure.lowest")
    return type(example)(**fields)


def _shape(size: list[int], name: str) -> tuple[int, ...]:
    if any(length < 0 for length in size) or np.prod([1, *size], dtype=float) > MOST_FACTORS:
        raise InputError(
            f"structure.sizes.{name} is {size}, should be lengths of at most {MOST_FACTORS} factors"
        )
    return tuple(size)


def _check(entry: HysteresisModel, record: Record) -> Record:
    if not entry.is_well_posed(record):
        raise InputError(
            f"its parameters make no '{entry.name}' model; identify again instead of changing "
            "values by hand"
        )
    return record


def _refuse_others(values: Mapping[str, float], known: Sequence[str]) -> None:
    for name in values:
        if name not in known:
            raise InputError(unknown(f"key parameters.{name}", name, known, "the model"))
