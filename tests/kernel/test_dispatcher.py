"""A core function serves Python and compiled code, each with machine code of its own."""

import pickle
from typing import NamedTuple

import pytest
from numba import config

from opensuction.kernel.compiled import compiled
from opensuction.kernel.dispatcher import Outer

plain = pytest.mark.skipif(
    getattr(config, "DISABLE_JIT"),  # noqa: B009 - numba sets it as it is imported
    reason="nothing is compiled",
)


class Place(NamedTuple):
    depth_mm: float
    inside: bool


@compiled
def _moved(place: Place, step_mm: float) -> Place:
    return Place(depth_mm=place.depth_mm + step_mm, inside=place.inside)


@compiled
def twice(place: Place, step_mm: float) -> Place:
    return _moved(_moved(place, step_mm), step_mm)


HERE = Place(1.0, True)


@plain
def test_a_callee_is_compiled_without_what_python_needs() -> None:
    assert twice(HERE, 2.0) == Place(5.0, True)
    assert isinstance(_moved, Outer)
    assert not _moved.overloads
    assert len(_moved.inner.overloads) == 1
    with pytest.raises(TypeError, match="_moved is compiled for compiled callers only"):
        _moved.inner(HERE, 2.0)


@plain
def test_python_can_call_a_callee_too() -> None:
    assert twice(HERE, 2.0) == _moved(_moved(HERE, 2.0), 2.0)
    assert isinstance(_moved, Outer)
    assert len(_moved.overloads) == 1


@plain
def test_it_survives_being_sent_to_another_process() -> None:
    sent = pickle.loads(pickle.dumps(twice))
    assert sent(HERE, 1.0) == Place(3.0, True)
