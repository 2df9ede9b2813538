"""The translation is the function: on numbers it gives what the compiled function gives.

And a proof of a function with a mistake in it fails.
"""

import ast
import inspect
import math
import textwrap
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import pytest
import z3
from hypothesis import given, settings
from hypothesis import strategies as st

from opensuction.control import servo
from opensuction.control.servo import Servo, ServoState
from opensuction.kernel.interface import Readings, Setpoints
from opensuction.procedure.cycle import cycle
from opensuction.safety.governor import judgement, limiter
from opensuction.safety.head import head_vote
from opensuction.safety.head.head_vote import HeadVote
from opensuction.safety.limits import DriveLimits, Limits
from opensuction.safety.watch import watch
from opensuction.safety.watch.watch_state import Watch
from tests.proof import test_narrowing, test_number, test_transition, test_way_out
from tools.proof import arithmetic, source, theorem
from tools.proof.abstract_double import AbstractDoubles, Double
from tools.proof.arithmetic import Doubles
from tools.proof.exact_double import ExactDoubles
from tools.proof.logic import Choice, as_integer, has_mask
from tools.proof.theorem import needed_facts
from tools.proof.translation import Translation
from tools.proof.unknown import free

NUMBERS = st.one_of(
    st.floats(-100.0, 100.0),
    st.sampled_from([0.0, 0.5, 10.0, 120.0, 1e6, -1e6, math.inf, -math.inf, math.nan]),
)
FINITE = st.floats(-200.0, 200.0)
POSITIVE = st.floats(0.1, 100.0)


def values(kind: Any, name: str = "") -> st.SearchStrategy[Any]:
    """Values of a type: any numbers in what is proposed and read, else such as a machine has."""
    if kind is bool:
        return st.booleans()
    if kind is int:
        few = [0, 0, 1, 1 << 3, 1 << 14, 1 << 19] if name == "trips" else [0, 1, 2, 5, 6, 39, 40]
        return st.sampled_from(few)
    if kind is float:
        if name in ("proposal", "readings"):
            return NUMBERS
        return POSITIVE if name in ("limits", "servo", "drive") else FINITE
    hints = inspect.get_annotations(kind)
    return st.tuples(*(values(one, name) for one in hints.values())).map(lambda v: kind(*v))


CASES: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "narrow": (
        limiter.narrow,
        {"limits": Limits, "last": Setpoints, "seen": Watch, "proposal": Setpoints, "trips": int},
    ),
    "servo": (
        servo.step,
        {"servo": Servo, "state": ServoState, "at": float, "speed": float, "readings": float},
    ),
    "vote": (
        head_vote.step,
        {
            "drive": DriveLimits,
            "before": HeadVote,
            "readings": Readings,
            "driven": bool,
            "volts": float,
            "speed": float,
            "apart": bool,
        },
    ),
}
"""Functions with the kinds of their arguments; the last one is a tick of 1 ms."""


def leaves(value: Any) -> Iterator[Any]:
    """The numbers and flags of a record, in order."""
    if isinstance(value, tuple) and not isinstance(value, Double | Choice):
        for one in value:
            yield from leaves(one)
    else:
        yield value


def translate(doubles: Doubles, name: str) -> tuple[list[Any], list[Any]]:
    """Unknown arguments and results of a function, flat."""
    function, kinds = CASES[name]
    unknowns = [free(doubles, kind, key) for key, kind in kinds.items()]
    result = Translation(doubles).run(function, *unknowns, 0.001)
    return list(leaves(tuple(unknowns))), list(leaves(result))


def write(unknown: Any, value: Any) -> Any:
    """A value as a constant of the same sort."""
    if isinstance(value, bool):
        return z3.BoolVal(value)
    if isinstance(value, float):
        return z3.FPVal(value, z3.Float64())
    return z3.BitVecVal(value, 64) if has_mask(unknown) else z3.IntVal(value)


def read(term: Any) -> Any:
    """The value of a constant term."""
    if isinstance(term, bool | int | float):
        return term
    if z3.is_bool(term):
        return z3.is_true(term)
    if z3.is_fp(term):
        if term.isNaN() or term.isInf():
            return math.nan if term.isNaN() else math.copysign(math.inf, -term.isNegative() + 0.5)
        exact = z3.simplify(z3.fpToReal(term))
        return float(exact.as_fraction())
    return term.as_long()


EXACT: dict[str, tuple[list[Any], list[Any]]] = {}


@pytest.mark.parametrize("name", CASES)
@given(data=st.data())
def test_the_translation_gives_what_the_compiled_function_gives(name: str, data: Any) -> None:
    function, kinds = CASES[name]
    if name not in EXACT:
        EXACT[name] = translate(ExactDoubles(), name)
    unknowns, results = EXACT[name]
    given_ = tuple(data.draw(values(kind, key)) for key, kind in kinds.items())
    pairs = [(one, write(one, value)) for one, value in zip(unknowns, leaves(given_), strict=True)]
    computed = list(leaves(function(*given_, 0.001)))
    for result, expected in zip(results, computed, strict=True):
        term = as_integer(result) if isinstance(result, Choice) else result
        if isinstance(term, z3.ExprRef):
            term = z3.simplify(z3.substitute(term, *pairs))
        # Fused products and sums differ in the last bit.
        assert read(term) == pytest.approx(expected, rel=1e-9, abs=1e-12, nan_ok=True)


def pin(unknown: Any, value: Any) -> z3.BoolRef:
    """That an abstract unknown is a value."""
    if not isinstance(unknown, Double):
        term = as_integer(unknown) if isinstance(unknown, Choice) else unknown
        return z3.BoolVal(term == value) if isinstance(term, bool | int) else term == value
    flags = (math.isnan(value), value == math.inf, value == -math.inf)
    held = [
        flag if is_ else z3.Not(flag)
        for flag, is_ in zip(
            (z3.BoolVal(one) if isinstance(one, bool) else one for one in unknown[1:4]),
            flags,
            strict=True,
        )
    ]
    if math.isfinite(value):
        held.append(unknown.real == z3.RealVal(str(Fraction(value))))
    return z3.And(held)


ABSTRACT: dict[str, tuple[AbstractDoubles, list[Any], list[Any], list[z3.BoolRef]]] = {}


def parts(value: Any) -> list[Any]:
    """The terms of a result."""
    if isinstance(value, Double):
        return [value.real, value.nan, value.up, value.down]
    return [as_integer(value)] if isinstance(value, Choice) else [value]


def translate_abstractly(
    name: str,
) -> tuple[AbstractDoubles, list[Any], list[Any], list[z3.BoolRef]]:
    """As `translate`, with the facts about what it has made."""
    doubles = AbstractDoubles()
    unknowns, results = translate(doubles, name)
    terms = [part for result in results for part in parts(result)]
    needed = needed_facts(doubles, *(part for part in terms if isinstance(part, z3.ExprRef)))
    return doubles, unknowns, results, needed


@pytest.mark.parametrize("name", CASES)
@settings(max_examples=6)
@given(data=st.data())
def test_the_abstraction_holds_what_the_compiled_function_gives(name: str, data: Any) -> None:
    function, kinds = CASES[name]
    if name not in ABSTRACT:
        ABSTRACT[name] = translate_abstractly(name)
    doubles, unknowns, results, needed = ABSTRACT[name]
    given_ = tuple(data.draw(values(kind, key)) for key, kind in kinds.items())
    computed = list(leaves(function(*given_, 0.001)))
    pairs = [*zip(unknowns, leaves(given_), strict=True), *zip(results, computed, strict=True)]
    pins = [
        pin(arithmetic.lift_double(doubles, one) if isinstance(one, float) else one, value)
        for one, value in pairs
    ]
    solver = z3.Solver()
    solver.add(*pins, *needed)
    assert solver.check() == z3.sat


MISTAKES: dict[str, tuple[Callable[..., Any], str, str, Callable[[], None]]] = {
    "the proposal is forgotten": (
        limiter._narrow_head,
        "wanted_mm = min(proposal.head_mm, highest)",
        "wanted_mm = highest",
        lambda: test_narrowing.test_the_command_goes_no_further_in_than_proposed(
            test_narrowing.narrow(None)
        ),
    ),
    "the valve opens unasked": (
        limiter._narrow_suction,
        "proposal.valve_open and not cut",
        "not cut",
        lambda: test_narrowing.test_valve_and_pump_are_never_more_than_proposed(
            test_narrowing.narrow(None)
        ),
    ),
    "the vacuum is at its limit": (
        limiter._narrow_suction,
        "min(proposal.vacuum_mmhg, highest)",
        "highest",
        lambda: test_narrowing.test_vacuum_is_never_more_than_proposed(test_narrowing.narrow(None)),
    ),
    "it withdraws from the deeper one": (
        limiter._withdraw_head,
        "origin = min(command_mm, seen.head_mm)",
        "origin = max(command_mm, seen.head_mm)",
        lambda: test_narrowing.test_a_withdrawal_is_commanded_outwards_of_the_head(
            test_narrowing.narrow(None)
        ),
    ),
    "it may advance under vacuum": (
        limiter._narrow_head,
        "if held:",
        "if held and stopped:",
        lambda: test_narrowing.test_no_advance_under_vacuum(test_narrowing.narrow(None)),
    ),
    "the clock of the airway rests while it sucks": (
        watch._extend_durations,
        "extend_duration(durations.inside_s, inside, dt_s)",
        "extend_duration(durations.inside_s, inside and not sucking, dt_s)",
        lambda: test_way_out.test_the_clock_of_the_airway_goes_on(test_way_out.guard()),
    ),
    "the valve is open on the way in": (
        cycle._valve_wanted,
        "return phase == Phase.SUCTIONING",
        "return phase in (Phase.INSERTING, Phase.SUCTIONING)",
        lambda: test_transition.test_the_valve_is_asked_for_in_these_phases_only(
            test_transition.step_cycle(AbstractDoubles())
        ),
    ),
    "the volts have no limit outwards": (
        servo.step,
        "max(volts, -servo.voltage_limit_v)",
        "volts",
        test_number.test_the_volts_are_within_the_supply,
    ),
    "an impossible proposal is taken": (
        judgement._is_possible,
        "math.isfinite(proposal.head_mm)\n        and ",
        "",
        test_narrowing.test_an_impossible_proposal_trips_at_once,
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_no_theorem(mistake: str, monkeypatch: pytest.MonkeyPatch) -> None:
    function, right, wrong, prove_it = MISTAKES[mistake]
    original = source.plain(function)
    text = textwrap.dedent(inspect.getsource(original))
    assert text.count(right) == 1
    (mistaken,) = ast.parse(text.replace(right, wrong)).body
    tree_of = source.tree_of

    def mislead(asked: Any) -> Any:
        return mistaken if asked is original else tree_of(asked)

    monkeypatch.setattr(source, "tree_of", mislead)
    with pytest.raises(pytest.fail.Exception, match="does not hold"):
        prove_it()


def _loops(value: float) -> float:
    while value > 1.0:
        value = value - 1.0
    return value


def test_what_is_not_known_is_not_guessed() -> None:
    doubles = AbstractDoubles()
    with pytest.raises(NotImplementedError, match="while value"):
        Translation(doubles)._run(_loops, [doubles.free("value")], {}, True)
    with pytest.raises(NotImplementedError, match="is not known"):
        Translation(doubles).run(math.sin, doubles.free("value"))


def test_what_takes_too_many_steps_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(theorem, "STEPS", 10_000)
    doubles = ExactDoubles()
    one, other = doubles.free("one"), doubles.free("other")
    product = doubles.multiply(one, other)
    with pytest.raises(TimeoutError, match="resource limit"):
        theorem.prove(doubles, doubles.less(one, other), doubles.less(product, other))
