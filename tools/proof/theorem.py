"""Asking z3: whether something holds for all unknowns, and if not, for which it does not."""

import time
from typing import Any, NamedTuple

import z3

from tools.proof.arithmetic import Doubles
from tools.proof.logic import Truth, lift_truth

STEPS = 1_000_000_000
"""Steps that z3 may take for an answer, as it counts them: the same on any computer, however busy.
All proofs of the project together take 240 million."""


class Answer(NamedTuple):
    """Result of z3."""

    holds: bool
    counterexample: dict[str, str]
    """By the names of the unknowns, where it does not hold."""
    seconds: float


def _unknowns(term: z3.ExprRef, seen: set[int], names: set[str]) -> None:
    stack = [term]
    while stack:
        one = stack.pop()
        if one.get_id() in seen:
            continue
        seen.add(one.get_id())
        if z3.is_const(one) and one.decl().kind() == z3.Z3_OP_UNINTERPRETED:
            names.add(str(one))
        stack.extend(one.children())


def needed_facts(doubles: Doubles, *terms: Truth) -> list[z3.BoolRef]:
    """The facts about every unknown that the terms depend on, and no others."""
    seen: set[int] = set()
    names: set[str] = set()
    for term in terms:
        _unknowns(lift_truth(term), seen, names)
    needed: dict[str, z3.BoolRef] = {}
    open_names = set(names)
    while open_names:
        name = open_names.pop()
        fact = doubles.facts.get(name)
        if fact is None or name in needed:
            continue
        needed[name] = fact.holds
        found: set[str] = set()
        _unknowns(fact.holds, seen, found)
        open_names |= found
    return list(needed.values())


def prove(doubles: Doubles, assumed: Truth, claim: Truth) -> Answer:
    """Answer to a claim from what is assumed: a proof, or a counterexample.

    Raises TimeoutError where z3 does not know after `STEPS`.
    """
    begun = time.perf_counter()
    solver = z3.Solver()
    solver.set("rlimit", STEPS)
    solver.add(lift_truth(assumed), z3.Not(lift_truth(claim)))
    solver.add(*needed_facts(doubles, assumed, claim))
    result = solver.check()
    seconds = time.perf_counter() - begun
    if result == z3.unknown:
        raise TimeoutError(f"z3 does not know after {seconds:.0f} s: {solver.reason_unknown()}")
    if result == z3.unsat:
        return Answer(True, {}, seconds)
    model = solver.model()
    named = {str(one): model[one] for one in model.decls()}
    return Answer(False, {name: _write(named[name]) for name in sorted(named)}, seconds)


def _write(value: Any) -> str:
    """A value of a model, as short as can be."""
    if z3.is_rational_value(value):
        try:
            return repr(float(value.as_fraction()))
        except OverflowError:
            return "beyond the largest double"
    return str(value)


def is_possible(doubles: Doubles, assumed: Truth) -> bool:
    """True where anything fulfils what is assumed: from what nothing fulfils all follows."""
    return not prove(doubles, assumed, False).holds
