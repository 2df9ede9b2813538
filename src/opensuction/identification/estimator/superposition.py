"""Models that are superpositions of known elements: generalised, Prandtl-Ishlinskii, Preisach.

Each offers `linear.fit` some designs of growing complexity and makes a model of what was chosen.
The past of a recording is unknown: a long advance, a long retract and rest are tried.
"""

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from opensuction.hysteresis import generalised, preisach
from opensuction.hysteresis.generalised import Generalised
from opensuction.hysteresis.preisach import Preisach
from opensuction.identification.estimator.linear import (
    Design,
    LinearFit,
    Solve,
    fit,
    solve_free,
    solve_nonnegative,
)
from opensuction.identification.estimator.projection import thinned

Array = NDArray[np.float64]

PASTS = (-1.0, 0.0, 1.0)
"""Memory ratios tried: after a long retract, at rest, after a long advance."""

DECAY_SETS = ((0.1,), (0.03, 0.1), (0.01, 0.03, 0.1, 0.3))
"""Decay lengths of the generalised model, as shares of the range of the input: from one state to
four, threefold apart."""

WIDTH_SETS = ((), (0.02, 0.08, 0.32), (0.01, 0.02, 0.04, 0.08, 0.16, 0.32))
"""Full widths of its plays, likewise: none, fourfold and twofold apart."""

DEGREES = (1, 3, 5)
"""Degrees of its envelope: even ones bend the two ends differently and come with the next odd."""

PENALTIES = (1e-6, 1e-5, 1e-4)
"""Ridge, as a share of a column's variance: a thousandth to a hundredth of it in amplitude."""

PLAY_COUNTS = (5, 10, 20, 40)
"""Plays of the Prandtl-Ishlinskii model, evenly spaced from no width to ``WIDEST``."""

WIDEST = 0.5
"""Widest play, as a share of the input's range: a wider one moves for less than half of it."""

LEVELS = (5, 10, 15)
"""Levels of the Preisach model: 15, 55 and 120 cells."""

LEVEL_PENALTIES = (1e-5, 1e-3)
"""Its penalties: cells that the recording hardly visits are pulled to 0."""

MARGIN = 0.02
"""By how much its grid reaches beyond the range of the recording, as a share of it."""

SAMPLES = 4000
"""Samples that the fit of many cells uses; turns of the input are always kept."""


class Superposition(NamedTuple):
    """A fitted superposition."""

    weights: dict[str, tuple[float, str]]
    """Name, value and unit of every factor; {in} and {out} stand for the recording's units."""
    simulate: Callable[[Array], Array]
    """Output for a record that begins as the fitted one did."""
    well_posed: bool
    cross_validation: float
    """Error of the blocks left out, in units of the output."""
    used: int
    """Factors that are not zero, the offset included."""
    nonnegative: bool
    """Whether its weights were held at 0 or above: then it never moves the wrong way."""


def fit_generalised(input_: Array, output: Array) -> Superposition:
    """Dahl states, plays and an envelope; which of them, cross-validation decides."""
    low, high = float(input_.min()), float(input_.max())
    options = list(product(DECAY_SETS, WIDTH_SETS, DEGREES, PENALTIES))

    def model_of(decays: tuple[float, ...], widths: tuple[float, ...], degree: int) -> Generalised:
        """An empty model with elements of these shares of the range."""
        range_ = high - low
        return generalised.on_range(
            low, high, range_ * np.array(decays), range_ * np.array(widths), degree
        )

    def designs(past: float) -> list[Design]:
        """Every option on the elements after one past, in the order of ``options``."""
        made = {}
        for decays, widths, degree in product(DECAY_SETS, WIDTH_SETS, DEGREES):
            model = model_of(decays, widths, degree)
            columns = _columns(model, input_, past)
            place = model.weights.size
            # The line is never penalised: it comes last, its constant is the offset.
            kept = [*range(place), *range(place + 2, len(columns)), place + 1]
            made[decays, widths, degree] = columns[kept]
        return [Design(made[option[:3]], option[3], spared=1) for option in options]

    past, found = _best_past(designs, output, solve_free)
    decays, widths, degree, _ = options[found.chosen]
    model = model_of(decays, widths, degree)
    elements = model.weights.size
    envelope = [found.offset, found.factors[-1], *found.factors[elements:-1]]
    model = generalised.with_factors(model, np.array([*found.factors[:elements], *envelope]))
    return _of_generalised(model, past, found, _names(decays, widths), nonnegative=False)


def fit_prandtl_ishlinskii(input_: Array, output: Array) -> Superposition:
    """Plays of known widths with weights >= 0; how many, cross-validation decides.

    For any recording, of unknown past. A compensator's plays come from a known excitation by
    `prandtl_ishlinskii.fit`, which says why there are two.
    """
    low, high = float(input_.min()), float(input_.max())
    grids = [np.linspace(0.0, WIDEST, count + 1) for count in PLAY_COUNTS]
    models = [
        generalised.on_range(low, high, np.empty(0), (high - low) * grid, 0) for grid in grids
    ]

    def designs(past: float) -> list[Design]:
        """Each grid of plays after one past."""
        return [
            Design(_columns(model, input_, past)[:-1], penalty=0.0, spared=0) for model in models
        ]

    past, found = _best_past(designs, output, solve_nonnegative)
    open_ = found.factors > 0.0
    grid = grids[found.chosen][open_]
    model = generalised.with_factors(
        generalised.on_range(low, high, np.empty(0), (high - low) * grid, 0),
        np.array([*found.factors[open_], found.offset]),
    )
    return _of_generalised(model, past, found, _names((), grid.tolist()), nonnegative=True)


def fit_preisach(input_: Array, output: Array) -> Superposition:
    """A triangle of relays with weights >= 0; how fine, cross-validation decides."""
    short_input, short_output = thinned(input_, output, SAMPLES)
    reach = MARGIN * float(np.ptp(input_))
    low, high = float(input_.min()) - reach, float(input_.max()) + reach
    options = list(product(LEVELS, LEVEL_PENALTIES))

    def designs(past: float) -> list[Design]:
        """Every option on the cells after one past, in the order of ``options``."""
        made = {}
        for levels in LEVELS:
            empty = Preisach(low, high, np.zeros((levels, levels)), 0.0)
            start = preisach.start_positions_mm(empty, float(input_[0]), past)
            made[levels] = preisach.basis(empty, short_input, start).T[:-1]
        return [Design(made[levels], penalty, spared=0) for levels, penalty in options]

    past, found = _best_past(designs, short_output, solve_nonnegative)
    levels = options[found.chosen][0]
    factors = np.array([*found.factors, found.offset])
    model = preisach.from_factors(low, high, levels, factors)
    weights = {
        f"cell_{k}_{place}": (float(model.weights_mm[k, place]), "{out}")
        for k in range(levels)
        for place in range(levels - k)
        if model.weights_mm[k, place] > 0.0
    }

    def simulate(record: Array) -> Array:
        """Output for a record that begins after the same past."""
        start = preisach.start_positions_mm(model, float(record[0]), past)
        return preisach.simulate(model, record, start)

    return Superposition(
        weights={**weights, "offset": (model.offset_mm, "{out}")},
        simulate=simulate,
        well_posed=bool(preisach.is_monotone(model)),
        cross_validation=found.cross_validation,
        used=found.used,
        nonnegative=True,
    )


def _best_past(
    designs: Callable[[float], list[Design]], output: Array, solve: Solve
) -> tuple[float, LinearFit]:
    """The past that predicts best, and the fit that goes with it."""
    found = [(past, fit(designs(past), output, solve)) for past in PASTS]
    return min(found, key=lambda each: each[1].cross_validation)


def _columns(model: Generalised, input_: Array, past: float) -> Array:
    """Elements and envelope terms of a record after one past, shape (factors, n)."""
    start = generalised.start_elements_mm(model, float(input_[0]), past)
    return generalised.basis(model, input_, start).T


def _of_generalised(
    model: Generalised, past: float, found: LinearFit, names: list[str], nonnegative: bool
) -> Superposition:
    """What was found, as a generalised model with its factors. names: of its elements."""
    named = {
        name: (float(weight), "{out}/{in}")
        for name, weight in zip(names, model.weights, strict=True)
    }
    envelope = {f"envelope_{k}": (float(c), "{out}") for k, c in enumerate(model.envelope_mm)}

    def simulate(record: Array) -> Array:
        """Output for a record that begins after the same past."""
        start = generalised.start_elements_mm(model, float(record[0]), past)
        return generalised.simulate(model, record, start)

    return Superposition(
        weights={**named, **envelope},
        simulate=simulate,
        well_posed=bool(generalised.is_monotone(model)),
        cross_validation=found.cross_validation,
        used=found.used,
        nonnegative=nonnegative,
    )


def _names(decays: Sequence[float], widths: Sequence[float]) -> list[str]:
    """Every element by its scale, in percent of the input's range."""
    return [
        *(f"lag_weight_{100.0 * share:.4g}_percent" for share in decays),
        *(f"play_weight_{100.0 * share:.4g}_percent" for share in widths),
    ]
