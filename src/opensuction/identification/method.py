"""Models that can be identified from a recording, and the methods for each."""

from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import (
    HysteresisModel,
    LinearForm,
    VectorForm,
)
from opensuction.identification.estimator.search import SEARCHES
from opensuction.kernel.errors import InputError

MODELS = {name: model for name, model in CATALOGUE.items() if model.form is not None}
"""Models that can be identified from any recording."""

METHODS = {
    "variable-projection": "linear parameters solved exactly, a global search over the others",
    "genetic-algorithm": "the paper's way: a genetic algorithm, then Nelder-Mead",
    "differential-evolution": "differential evolution, then Nelder-Mead",
    "non-negative": "least squares with weights at least 0, complexity by cross-validation",
    "rising": "non-negative, and nothing else that could move the output the wrong way",
    "regularised": "least squares with a penalty, complexity by cross-validation",
}
"""Ways to identify them, and what they are."""

COUPLED = "play-readout"
"""The model that follows several inputs."""

RISING = "rising"
"""The method for a model that is to drive a head."""


def methods_of(model: HysteresisModel) -> tuple[str, ...]:
    """Names of the methods that can identify a model; the first is its default."""
    if model.name == COUPLED:
        return ("non-negative", RISING)
    match model.form:
        case VectorForm():
            return ("variable-projection", *SEARCHES)
        case LinearForm(nonnegative=nonnegative):
            return ("non-negative",) if nonnegative else ("regularised",)
        case None:
            return ()


def choose_for(model: HysteresisModel, purpose: str) -> str:
    """The method for a purpose: a model that is to drive a head must be able to."""
    methods = methods_of(model)
    return RISING if purpose == "compensate" and RISING in methods else methods[0]


def choose_method(model: str, method: str | None) -> str:
    """The method to use; InputError for an unknown name or a pair that does not go together."""
    if model not in MODELS:
        raise InputError(f"model '{model}' is not known: one of {', '.join(MODELS)}")
    methods = methods_of(MODELS[model])
    if method is None:
        return methods[0]
    if method not in METHODS:
        raise InputError(f"method '{method}' is not known: one of {', '.join(METHODS)}")
    if method not in methods:
        raise InputError(
            f"method '{method}' cannot identify model '{model}': one of {', '.join(methods)}"
        )
    return method
