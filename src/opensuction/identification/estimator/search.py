"""Global searches over every parameter at once, each finished by Nelder and Mead's simplex.

The paper's way: a genetic algorithm, then Nelder-Mead. And differential evolution in its place.
Lots are drawn inside the usual bounds; the simplex leaves them, up to the limits.
Both are here to be compared with variable projection, which finds the same optimum sooner.
Source: [paper] III-B; [Storn-1997]; [Nelder-1965]; [Deb-1995] (bounded crossover).
"""

import random
from collections.abc import Callable

import numpy as np

from opensuction.hysteresis.catalogue.hysteresis_model import VectorForm, ranges_of
from opensuction.identification.estimator.linear import squares
from opensuction.identification.single_thread import load
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

Cost = Callable[[Array], float]

SEED = 1
"""A search that draws lots draws the same ones each time."""

POPULATION = 100
"""Individuals of the genetic algorithm [assumed]: the paper does not say."""

GENERATIONS = 100
"""Its generations [assumed]."""

CROSSOVER, MUTATION = 0.9, 0.3
"""How likely a pair is crossed and an individual mutated [assumed]."""

CROWDING = 20.0
"""Spread index of bounded crossover and mutation: how near children stay to their parents."""

TOLERANCE = 1e-8
"""Of differential evolution: spread of the population's costs over their mean."""

SIMPLEX_STEPS = 4000
"""Bound on the steps and costs of Nelder-Mead."""


def genetic_algorithm(cost: Cost, places: int, seed: int = SEED) -> Array:
    """Best vector in the unit cube that DEAP's genetic algorithm finds.

    Raises InputError where DEAP is not installed.
    """
    try:
        from deap import algorithms, base, tools
    except ImportError:
        raise InputError(
            "method 'genetic-algorithm' needs the package deap: pip install 'opensuction[genetic]'"
        ) from None

    class Fitness(base.Fitness):  # type: ignore[misc]
        """One cost, to be made small."""

        weights = (-1.0,)

    class Individual(list[float]):
        """A place in the unit cube with its fitness, as DEAP wants it."""

        def __init__(self, values: list[float]) -> None:
            super().__init__(values)
            self.fitness = Fitness()

    bounds = {"low": 0.0, "up": 1.0, "eta": CROWDING}
    toolbox = base.Toolbox()
    toolbox.register("evaluate", lambda individual: (cost(np.array(individual)),))
    toolbox.register("mate", tools.cxSimulatedBinaryBounded, **bounds)
    toolbox.register("mutate", tools.mutPolynomialBounded, indpb=1.0 / places, **bounds)
    toolbox.register("select", tools.selTournament, tournsize=3)
    # DEAP draws from Python's own stream: it is seeded here, and given back as it was.
    before = random.getstate()
    try:
        random.seed(seed)
        population = [
            Individual([random.random() for _ in range(places)]) for _ in range(POPULATION)
        ]
        best = tools.HallOfFame(1)
        algorithms.eaSimple(
            population, toolbox, CROSSOVER, MUTATION, GENERATIONS, halloffame=best, verbose=False
        )
    finally:
        random.setstate(before)
    return np.array(best[0])


def evolution(cost: Cost, places: int, seed: int = SEED) -> Array:
    """Best vector in the unit cube that scipy's differential evolution finds, unpolished."""
    box = [(0.0, 1.0)] * places
    optimize = load("scipy.optimize")
    found = optimize.differential_evolution(cost, box, seed=seed, tol=TOLERANCE, polish=False)
    return np.asarray(found.x)


SEARCHES = {"genetic-algorithm": genetic_algorithm, "differential-evolution": evolution}


def search(method: str, form: VectorForm, input_: Array, output: Array, seed: int = SEED) -> Array:
    """The vector with the least sum of squares that a search and Nelder-Mead find.

    method: a name of ``SEARCHES``. input_, output: shape (n,). Returns shape (p,).
    """
    # About their means, so that slope and offset do not hide one another from a search.
    middle = np.array([float(input_.mean()), float(output.mean())])
    moved, target = input_ - middle[0], output - middle[1]
    ranges = ranges_of(moved, target)
    edges, limits = form.bounds(ranges), form.limits(ranges)
    logarithmic = np.array([parameter.logarithmic for parameter in form.parameters])
    with np.errstate(divide="ignore"):  # of a limit of 0
        edges[logarithmic], limits[logarithmic] = (
            np.log(each[logarithmic]) for each in (edges, limits)
        )
    width = edges[:, 1] - edges[:, 0]
    lowest, highest = ((limits - edges[:, :1]) / width[:, None]).T

    def vector(place: Array) -> Array:
        """Parameters at a place, whose unit cube are the bounds; at a limit those beyond it."""
        value = edges[:, 0] + np.clip(place, lowest, highest) * width
        value[logarithmic] = np.exp(value[logarithmic])
        return value

    def cost(place: Array) -> float:
        """Sum of squares, growing with the distance beyond the limits."""
        outside = place - np.clip(place, lowest, highest)
        return squares(form, vector(place), moved, target) * (1.0 + float(outside @ outside))

    start = SEARCHES[method](cost, len(form.parameters), seed)
    options = {
        "xatol": 1e-9,
        "fatol": 1e-12 * float(target @ target),
        "maxiter": SIMPLEX_STEPS,
        "maxfev": SIMPLEX_STEPS,
    }
    least = load("scipy.optimize").minimize(cost, start, method="Nelder-Mead", options=options)
    found = vector(np.asarray(least.x))
    names = [parameter.name for parameter in form.parameters]
    if "slope" in names:
        found[names.index("offset")] -= found[names.index("slope")] * middle[0]
    found[names.index("offset")] += middle[1]
    return found
