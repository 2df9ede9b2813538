"""Nothing decays for ever: a machine at rest computes with no number that is nearly nothing."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.evidence.safety_case.hazard_case import COMPENSATION
from opensuction.kernel.arithmetic import TINY, drop_tiny
from opensuction.kernel.interface import NO_REQUESTS, START
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation import closed_loop, trace

REST_S = 120.0
"""Thousands of time constants of the fast averages; after 708 a number is below 1e-307."""


@given(st.floats(allow_nan=False))
def test_only_what_is_nothing_is_dropped(value: float) -> None:
    assert drop_tiny(value) == (0.0 if abs(value) < TINY else value)


def test_what_is_no_number_is_not_made_one() -> None:
    assert np.isnan(drop_tiny(float("nan")))


def numbers(record: object, path: str) -> Iterator[tuple[str, float]]:
    if isinstance(record, tuple):
        names = getattr(record, "_fields", range(len(record)))
        for name, value in zip(names, record, strict=True):
            yield from numbers(value, f"{path}.{name}")
    elif isinstance(record, np.ndarray):
        yield from ((f"{path}[{i}]", float(value)) for i, value in enumerate(record.flat))
    elif isinstance(record, float):
        yield path, record


@pytest.mark.parametrize("machine", ["bench", "clinical"])
def test_nothing_is_nearly_nothing_after_two_minutes_at_rest(machine: str) -> None:
    rig = RigChoice(machine=machine, seed=1)
    ready = cycle_run.prepare(
        resolution.resolve(CycleChoice(rig, compensation=COMPENSATION, approach="travel"))
    )
    table = trace.rows(REST_S)
    state, _ = closed_loop.run(ready.loop, ready.start, START, table)
    state, ticks = closed_loop.run(ready.loop, state, NO_REQUESTS, table)
    assert ticks == len(table)
    slow = [path for path, value in numbers(state, "state") if 0.0 < abs(value) < TINY]
    assert slow == []
