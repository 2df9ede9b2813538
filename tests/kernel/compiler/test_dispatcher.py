"""A core function serves Python and compiled code; only what Python calls becomes machine code."""

import gc
import importlib
import pickle
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numba
import numpy as np
import pytest
from numba import config
from numba.core.runtime import nrt
from numpy.typing import NDArray

from opensuction.kernel import compiled as core_compiler
from opensuction.kernel.compiler import compilation
from opensuction.kernel.compiler.compilation import Compilation
from opensuction.kernel.compiler.dispatcher import CoreFunction
from opensuction.kernel.compiler.store import Store

pytestmark = pytest.mark.skipif(
    bool(getattr(config, "DISABLE_JIT")),  # noqa: B009 - numba sets it on import
    reason="nothing is compiled",
)


EMPTY = Path(tempfile.mkdtemp())
Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """As the core's, with a cache of its own: what earlier tests have kept compiles nothing."""
    made = core_compiler.compiled(function)
    if isinstance(made, CoreFunction):
        made.keep(EMPTY, Store(EMPTY / "translated", core_compiler.is_core))
    return made


class Place(NamedTuple):
    depth_mm: float
    inside: bool


@compiled
def _moved(place: Place, step_mm: float) -> Place:
    return Place(depth_mm=place.depth_mm + step_mm, inside=place.inside)


@compiled
def twice(place: Place, step_mm: float = 1.0) -> Place:
    return _moved(_moved(place, step_mm), step_mm)


@compiled
def thrice(place: Place, step_mm: float) -> Place:
    return _moved(twice(place, step_mm=step_mm), step_mm)


HERE = Place(1.0, True)


def core(function: Any) -> CoreFunction:
    """What the decorator made of a function."""
    assert isinstance(function, CoreFunction)
    return function


def test_a_callee_becomes_no_machine_code() -> None:
    assert thrice(HERE, 2.0) == Place(7.0, True)
    assert not core(_moved).overloads
    assert len(core(_moved).translations) == 1


def test_python_can_call_a_callee_too() -> None:
    assert twice(HERE, 2.0) == _moved(_moved(HERE, 2.0), 2.0)
    assert len(core(_moved).overloads) == 1
    assert len(core(_moved).translations) == 1  # not translated once more


def test_defaults_and_names_of_arguments_count_for_both_callers() -> None:
    @compiled
    def four_times(place: Place) -> Place:
        return twice(twice(place), step_mm=3.0)

    assert twice(HERE) == Place(3.0, True)
    assert four_times(HERE) == Place(9.0, True)


def test_other_types_of_arguments_are_other_translations() -> None:
    before = len(core(twice).translations)
    assert twice(Place(1, True), 2) == Place(5, True)
    assert len(core(twice).translations) == before + 1


def test_a_function_of_numba_alone_can_call_one_of_the_core() -> None:
    @numba.njit
    def foreign(place: Place) -> Place:
        return thrice(place, 1.0)

    anything: Any = foreign
    assert anything(HERE) == Place(4.0, True)


def test_compilation_can_be_disabled() -> None:
    assert twice(HERE, 2.0) == Place(5.0, True)
    core(twice).disable_compile()
    try:
        assert twice(HERE, 2.0) == Place(5.0, True)
        with pytest.raises((TypeError, RuntimeError)):
            twice(Place(1.0, 1), 2.0)  # type: ignore[arg-type]
    finally:
        core(twice).disable_compile(False)


@compiled
def _shares(whole: NDArray[np.float64], by: float) -> NDArray[np.float64]:
    return whole / by


class Held(NamedTuple):
    """A record with a reference that is counted, deep in it."""

    place: Place
    values: NDArray[np.float64]


@compiled
def _pick(held: Held, other: Held, first: bool) -> Held:
    if first:
        return held
    return Held(place=other.place, values=_shares(other.values, 2.0))


@compiled
def _hand_over(held: Held, times: int) -> tuple[Held, float]:
    kept = held
    total = 0.0
    for i in range(times):
        kept = _pick(kept, held, i % 3 == 0)
        total += kept.values[0]
    return kept, total


def test_no_reference_leaks_and_none_is_released_twice() -> None:
    importlib.import_module("numba.core.runtime._nrt_python").memsys_enable_stats()
    stats: Any = nrt.rtsys.get_allocation_stats

    def run(times: int) -> None:
        held = Held(HERE, np.full(3, 4.0))
        kept, total = _hand_over(held, times)
        assert kept.values.tolist() == ([4.0] * 3 if times <= 1 else [2.0] * 3)
        assert total == sum(4.0 if i == 0 else 2.0 for i in range(times))
        assert held.values.tolist() == [4.0] * 3

    run(50)
    gc.collect()
    before = stats()
    for times in (1, 2, 3, 50):
        run(times)
    gc.collect()
    after = stats()
    assert after.alloc - before.alloc == after.free - before.free
    assert after.mi_alloc - before.mi_alloc == after.mi_free - before.mi_free
    assert after.mi_alloc > before.mi_alloc


@compiled
def _refuse(place: Place, limit_mm: float) -> float:
    if place.depth_mm > limit_mm:
        raise ValueError(place.depth_mm, "mm is beyond", limit_mm)
    return place.depth_mm


@compiled
def check(place: Place, limit_mm: float) -> float:
    return _refuse(place, limit_mm)


def test_an_exception_of_a_callee_reaches_python_with_its_values() -> None:
    assert check(HERE, 2.0) == 1.0
    with pytest.raises(ValueError, match=r"1\.0, 'mm is beyond', 0\.5"):
        check(HERE, 0.5)


def test_the_collector_rests_only_while_compiling() -> None:
    collecting: list[bool] = []

    @compiled
    def fresh(x: float) -> float:
        return x

    def hear(_: Compilation) -> None:
        collecting.append(gc.isenabled())

    assert gc.isenabled()
    compilation.listen(hear)
    assert fresh(1.0) == 1.0
    compilation.listen(None)
    assert collecting
    assert not any(collecting)
    assert gc.isenabled()


def test_it_survives_being_sent_to_another_process() -> None:
    sent = pickle.loads(pickle.dumps(twice))
    assert sent(HERE, 1.0) == Place(3.0, True)
