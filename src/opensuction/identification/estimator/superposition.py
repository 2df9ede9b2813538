"""Models that are superpositions of known elements: generalised, Prandtl-Ishlinskii, Preisach.

The catalogue's `LinearForm` of a model offers elements from coarse to fine; `linear.fit` chooses.
The past of a recording is unknown: a long advance, a long retract and rest are tried.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    LinearForm,
    Record,
    ranges_of,
)
from opensuction.identification.estimator import linear
from opensuction.identification.estimator.linear import Design
from opensuction.identification.record import thin
from opensuction.kernel.record import Array

PASTS = (-1.0, 0.0, 1.0)
"""Memory ratios tried: after a long retract, at rest, after a long advance."""


class Superposition(NamedTuple):
    """A fitted superposition."""

    model: HysteresisModel
    record: Record
    memory_ratio: float
    """The past before the first sample that predicts best."""
    factors: dict[str, tuple[float, str]]
    """Name, value and unit of each factor, those held at 0 left out; {in} and {out} stand for the
    recording's units."""
    nonnegative: bool
    """Whether they were held at 0 or above."""
    cross_validation: float
    """Error of the blocks left out, in units of the output."""

    def simulate(self, input_: Array) -> Array:
        """Output for a record of inputs, shape (n,), that begins after the same past."""
        memory = self.model.memory(self.record, float(input_[0]), self.memory_ratio)
        return self.model.simulate(self.record, input_, memory)


def fit(model: HysteresisModel, input_: Array, output: Array) -> Superposition:
    """Fit a model that is linear in its factors; cross-validation decides how fine it is.

    input_, output: shape (n,), of any recording of unknown past. A compensator's plays come from
    a known excitation by `prandtl_ishlinskii.fit`, which says why there are two.
    Raises InputError where the factors cannot be found, TypeError for a model that is not linear.
    """
    form = model.form
    if not isinstance(form, LinearForm):
        raise TypeError(f"{model.name} is not linear in its parameters")
    ranges = ranges_of(input_, output)
    guesses = form.initial_guesses(ranges)
    samples, aim = input_, output
    if form.most_samples is not None:
        samples, aim = thin(input_, output, form.most_samples)

    def designs(past: float) -> list[Design]:
        """The elements of every guess after one past, with every penalty."""
        made = []
        for record in guesses:
            columns = form.basis(record, samples, model.memory(record, float(input_[0]), past)).T
            kept, _ = _order(len(columns), form.degree(record))
            made.append((columns[kept], min(form.degree(record), 1)))
        return [
            Design(columns, penalty, spared)
            for (columns, spared), penalty in product(made, form.penalties)
        ]

    solve = linear.solve_nonnegative if form.nonnegative else linear.solve_free
    fits = [(past, linear.fit(designs(past), aim, solve)) for past in PASTS]
    past, found = min(fits, key=lambda each: each[1].cross_validation)
    guess = guesses[found.chosen // len(form.penalties)]
    factors = np.empty(found.factors.size + 1)
    kept, constant = _order(factors.size, form.degree(guess))
    factors[kept], factors[constant] = found.factors, found.offset
    parameters = form.parameters(guess, ranges)
    reported = [
        place
        for place, factor in enumerate(factors)
        if factor > 0.0 or place == constant or not form.nonnegative
    ]
    return Superposition(
        model=model,
        record=form.with_factors(guess, factors),
        memory_ratio=past,
        factors={
            parameters[place].name: (float(factors[place]), parameters[place].unit)
            for place in reported
        },
        nonnegative=form.nonnegative,
        cross_validation=found.cross_validation,
    )


def _order(columns: int, degree: int) -> tuple[slice | list[int], int]:
    """Columns of a basis in the order they are fitted in, and which one is the constant.

    The constant is fitted by centring. The straight line behind it is never penalised: it is last.
    """
    constant = columns - 1 - degree
    if degree == 0:
        return slice(constant), constant
    return [*range(constant), *range(constant + 2, columns), constant + 1], constant
