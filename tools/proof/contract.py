"""Contracts of functions: precondition and postcondition, proved once, then used for the calls.

The same record serves for the proof and for its use, so what is used is what was proved. A function
that is too large to be proved together with all that it calls is proved on the contracts of those.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import z3

from tools.proof.arithmetic import Doubles
from tools.proof.logic import Truth, conjoin, lift_truth
from tools.proof.theorem import Answer, is_possible, prove
from tools.proof.translation import Translation, any_raises

Making = Callable[[Doubles, str], Any]
"""Makes unknowns, by a name that no others have."""


class Contract(NamedTuple):
    """Of one function."""

    function: Callable[..., Any]
    arguments: Callable[[Doubles], list[Any]]
    """Unknown arguments to prove it of."""
    result: Making
    """An unknown result."""
    requires: Callable[..., Truth]
    """Of the doubles and the arguments."""
    ensures: Callable[..., Truth]
    """Of the doubles, the result and the arguments."""


class Reliance(NamedTuple):
    """Duties and gains where contracts stood for functions."""

    owed: list[Truth]
    """What the callers had to fulfil."""
    given: list[Truth]
    """What may be assumed of the results."""


def prove_contract(
    contract: Contract, doubles: Doubles, translation: Translation
) -> tuple[Answer, Answer]:
    """Answers to two claims: it holds; the function never raises where its caller keeps it.

    Raises ValueError where no caller could keep it.
    """
    arguments = contract.arguments(doubles)
    asked = contract.requires(doubles, *arguments)
    result = translation.run(contract.function, *arguments)
    _refuse_nothing(doubles, asked)
    kept = prove(doubles, asked, contract.ensures(doubles, result, *arguments))
    return kept, prove(doubles, asked, z3.Not(any_raises(translation)))


def rely(
    contracts: list[Contract], doubles: Doubles
) -> tuple[dict[Callable[..., Any], Callable[..., Any]], Reliance]:
    """Summaries for a translation, and what is owed and given by relying on them."""
    reliance = Reliance([], [])

    def stand_in(contract: Contract) -> Callable[..., Any]:
        def summary(*arguments: Any) -> Any:
            name = f"{contract.function.__name__}:{len(reliance.given)}"
            result = contract.result(doubles, name)
            reliance.owed.append(contract.requires(doubles, *arguments))
            reliance.given.append(contract.ensures(doubles, result, *arguments))
            return result

        return summary

    return {contract.function: stand_in(contract) for contract in contracts}, reliance


def prove_on(reliance: Reliance, doubles: Doubles, assumed: Truth, claim: Truth) -> Answer:
    """Answer to a claim from what is assumed and from contracts whose duties are kept.

    Each duty may rest on what the contracts called before it gave. Raises ValueError where nothing
    fulfils all of it.
    """
    given: Truth = True
    begun: Answer | None = None
    for owed, gain in zip(reliance.owed, reliance.given, strict=True):
        begun = prove(doubles, conjoin(assumed, given), owed)
        if not begun.holds:
            return begun
        given = conjoin(given, gain)
    _refuse_nothing(doubles, conjoin(assumed, given))
    return prove(doubles, conjoin(assumed, given), lift_truth(claim))


def _refuse_nothing(doubles: Doubles, assumed: Truth) -> None:
    if not is_possible(doubles, assumed):
        raise ValueError("nothing fulfils what is assumed, so it proves nothing")
