"""A model that is held against others: of the catalogue, a yardstick, or somebody's estimator.

Each is fitted to the first part of a data set and gives its output for all of it, from the inputs
alone: what was measured of the held-out part is never fed to it. A model with memory is at the
beginning of that part in the state in which the fitted part left it.
"""

import copy
import importlib
import inspect
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from opensuction.evidence.leaderboard import mr_damper
from opensuction.evidence.leaderboard.data_set import Samples
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.oscillator.output_error import fit_oscillator
from opensuction.identification import workbench
from opensuction.identification.judgement.diagnosis import UNKNOWN_UNITS, Labels
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.settings.validation import choose

LINE, DAMPER, OSCILLATOR = "straight-line", "modified-bouc-wen", "bouc-wen-oscillator"
OF_ESTIMATOR = ("fit", "predict")
"""Methods of an estimator of scikit-learn that are called."""


class Contender(NamedTuple):
    """A model by name."""

    name: str
    words: str
    predict: Callable[[Samples], Array]
    """Fits the model; its output at every sample, shape (n,). Raises InputError in one line for
    data that it cannot be fitted to."""
    takes: Callable[[Samples], bool] = lambda _: True
    """False for data that it is no model of: it is left out there."""


def _predict_line(samples: Samples) -> Array:
    columns = np.column_stack([*samples.inputs, np.ones(samples.output.size)])
    known = slice(samples.fitted)
    weights = np.linalg.lstsq(columns[known], samples.output[known])[0]
    return np.asarray(columns @ weights, dtype=np.float64)


def _predict_damper(samples: Samples) -> Array:
    period_s = samples.data_set.period_s
    assert period_s is not None  # `_is_evenly_sampled`
    speed, voltage = samples.inputs
    known = slice(samples.fitted)
    found = mr_damper.fit(speed[known], voltage[known], samples.output[known], period_s)
    return mr_damper.simulate(found, speed, voltage, period_s)


def _predict_oscillator(samples: Samples) -> Array:
    period_s = samples.data_set.period_s
    assert period_s is not None  # `_is_evenly_sampled`
    force_n, known = samples.inputs[0], slice(samples.fitted)
    found = fit_oscillator(force_n[known], samples.output[known], 1.0 / period_s)
    return found.predict(force_n, found.start)


def _is_evenly_sampled(*units: str) -> Callable[[Samples], bool]:
    """Predicate of a data set of these units of inputs and output, evenly sampled."""

    def takes(samples: Samples) -> bool:
        return samples.data_set.units == units and samples.data_set.period_s is not None

    return takes


def _of_catalogue(name: str) -> Contender:
    def predict(samples: Samples) -> Array:
        data = samples.data_set
        inputs = samples.inputs if name == workbench.COUPLED else samples.inputs[:1]
        units = data.units or (*UNKNOWN_UNITS[:1] * len(data.inputs), UNKNOWN_UNITS[1])
        total = samples.output.size
        found = workbench.identify(
            inputs if len(inputs) > 1 else inputs[0],
            samples.output,
            samples.time_s,
            name,
            holdout_ratio=(total - samples.fitted + 0.5) / total,
            labels=Labels(
                data.inputs[0], data.output, units[0], units[-1], other_names=data.inputs[1:]
            ),
        )
        return found.fitted

    return Contender(name, CATALOGUE[name].title, predict)


BUILT_IN: Mapping[str, Contender] = {
    one.name: one
    for one in (
        *map(_of_catalogue, workbench.MODELS),
        Contender(
            DAMPER,
            "modified Bouc-Wen model of a damper that a voltage drives",
            _predict_damper,
            _is_evenly_sampled("cm/s", "V", "N"),
        ),
        Contender(
            OSCILLATOR,
            "mass with a Bouc-Wen force",
            _predict_oscillator,
            _is_evenly_sampled("N", "m"),
        ),
        Contender(LINE, "least-squares line over the inputs, without memory", _predict_line),
    )
}
"""Models that are known by name; the last one is a yardstick."""


def of_estimator(name: str, estimator: Any) -> Contender:
    """An estimator with scikit-learn's ``fit(X, y)`` and ``predict(X)``.

    It is copied and fitted to the rows of the fitted part, X of shape (samples, inputs), and
    predicts all rows at once, those before the held-out ones too, so that one with memory can go
    through them. Raises InputError for what lacks one of the two methods.
    """
    lacking = [one for one in OF_ESTIMATOR if not callable(getattr(estimator, one, None))]
    if lacking:
        raise InputError(f"model '{name}': has no {' and no '.join(lacking)}; give an estimator")

    def predict(samples: Samples) -> Array:
        rows = samples.inputs.T.copy()
        known = slice(samples.fitted)
        own = copy.deepcopy(estimator)
        try:
            own.fit(rows[known], samples.output[known].copy())
            found = np.asarray(own.predict(rows), dtype=np.float64)
        except Exception as error:  # somebody else's code: its failure is a result
            raise InputError(f"{type(error).__name__}: {error}") from None
        if found.size != samples.output.size:
            raise InputError(f"predicts {found.size} samples of {samples.output.size} rows")
        return found.reshape(-1)

    words = (inspect.getdoc(type(estimator)) or name).split("\n\n", 1)[0]
    return Contender(name, " ".join(words.split()), predict)


@contextmanager
def _current_folder() -> Any:
    """Modules of the current folder can be imported in here, as with ``python -m``."""
    here = str(Path.cwd())
    sys.path.insert(0, here)
    try:
        yield
    finally:
        sys.path.remove(here)


def _import(name: str) -> Any:
    """An estimator by ``module:Class``, which is called without arguments, or ``module:object``."""
    module, _, attribute = name.partition(":")
    try:
        with _current_folder():
            found = importlib.import_module(module)
    except Exception as error:  # the module is the user's, and may raise anything
        raise InputError(
            f"model '{name}': {module} cannot be imported ({type(error).__name__}: {error})"
        ) from None
    if not hasattr(found, attribute):
        raise InputError(f"model '{name}': {module} has no {attribute}")
    given = getattr(found, attribute)
    if not isinstance(given, type):
        return given
    try:
        return given()
    except Exception as error:
        raise InputError(
            f"model '{name}': cannot be made without arguments ({error}); give module:object, an "
            "estimator that is made in the module"
        ) from None


def select(given: Sequence[Any]) -> tuple[Contender, ...]:
    """Contenders by what was given, each once; all that are built in where nothing is.

    given: names of `BUILT_IN`, ``module:Class``, or estimators themselves. Raises InputError for
    what is none of them.
    """
    found: dict[str, Contender] = {}
    for one in given:
        if not isinstance(one, str):
            name = _free(type(one).__name__, found)
            found[name] = of_estimator(name, one)
        elif ":" in one:
            found[one] = of_estimator(one, _import(one))
        else:
            choose(one, BUILT_IN, "model")
            found[one] = BUILT_IN[one]
    return tuple(found.values() if given else BUILT_IN.values())


def _free(name: str, taken: Iterable[str]) -> str:
    """The name, numbered where another has it."""
    used = set(taken)
    numbered = (f"{name} {number}" for number in range(2, len(used) + 3))
    return next(one for one in (name, *numbered) if one not in used)
