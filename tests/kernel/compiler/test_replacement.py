"""Records change in place in compiled code, as they do in plain Python."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import config
from numba.core.errors import TypingError
from numpy.typing import NDArray

from opensuction.kernel.compiled import PACKAGE, compiled

memory: Any = import_module("numba.core.runtime._nrt_python")
"""Numba's own count of arrays."""

jit = pytest.mark.skipif(
    getattr(config, "DISABLE_JIT"),  # noqa: B009 - numba sets it as it is imported
    reason="nothing is compiled",
)


class Place(NamedTuple):
    depth_mm: float
    head_mm: float


class Tip(NamedTuple):
    place: Place
    ticks: int
    inside: bool
    plays_mm: NDArray[np.float64]


def tip() -> Tip:
    return Tip(Place(depth_mm=1.0, head_mm=2.0), ticks=3, inside=False, plays_mm=np.zeros(4))


@compiled
def advance(record: Tip, move_mm: float) -> Tip:
    place = record.place._replace(depth_mm=record.place.depth_mm + move_mm)
    return record._replace(place=place, inside=True)


@compiled
def swap(record: Tip) -> Tip:
    place = record.place
    return record._replace(place=place._replace(depth_mm=place.head_mm, head_mm=place.depth_mm))


@compiled
def whole(record: Tip) -> Tip:
    return record._replace(place=record.place._replace(depth_mm=record.ticks))


@compiled
def same(record: Tip) -> Tip:
    return record._replace()


@compiled
def double_plays(record: Tip) -> Tip:
    return record._replace(plays_mm=2.0 * record.plays_mm)


@compiled
def _turn_over(record: Tip, times: int) -> Tip:
    """An array that is replaced again and again, and one that stays."""
    for _ in range(times):
        record = record._replace(plays_mm=record.plays_mm + 1.0)
        record = record._replace(ticks=record.ticks + 1)
    return record


@compiled
def turn_over(record: Tip, times: int) -> float:
    return float(_turn_over(record, times).plays_mm.sum())


def test_what_is_not_named_stays_and_the_record_itself_does_not_change() -> None:
    before = tip()
    after = advance(before, 2.5)
    assert after[:3] == (Place(depth_mm=3.5, head_mm=2.0), 3, True)
    assert isinstance(after, Tip)
    assert isinstance(after.place, Place)
    assert before[:3] == tip()[:3]
    assert after.plays_mm is before.plays_mm or np.shares_memory(after.plays_mm, before.plays_mm)


def test_several_fields_take_the_values_from_before() -> None:
    assert swap(tip()).place == Place(depth_mm=2.0, head_mm=1.0)


def test_nothing_named_is_the_same_record() -> None:
    assert same(tip())[:3] == tip()[:3]


def test_an_integer_serves_a_float() -> None:
    assert whole(tip()).place == Place(depth_mm=3.0, head_mm=2.0)


@jit
def test_it_then_is_a_float_so_that_no_caller_is_compiled_once_more() -> None:
    assert isinstance(whole(tip()).place.depth_mm, float)


def test_an_array_is_replaced_and_the_old_one_left_alone() -> None:
    before = tip()._replace(plays_mm=np.array([1.0, 2.0, 3.0, 4.0]))
    after = double_plays(before)
    assert after.plays_mm.tolist() == [2.0, 4.0, 6.0, 8.0]
    assert before.plays_mm.tolist() == [1.0, 2.0, 3.0, 4.0]


@jit
def test_no_reference_to_an_array_is_leaked_or_lost() -> None:
    record = tip()
    turn_over(record, 1)
    memory.memsys_enable_stats()
    try:
        allocated, freed = memory.memsys_get_stats_alloc(), memory.memsys_get_stats_free()
        assert turn_over(record, 1000) == 4000.0
        allocated = memory.memsys_get_stats_alloc() - allocated
        freed = memory.memsys_get_stats_free() - freed
    finally:
        memory.memsys_disable_stats()
    assert allocated >= 1000
    assert allocated == freed
    assert record.plays_mm.tolist() == [0.0] * 4


@compiled
def _misspelt(record: Tip) -> Tip:
    return record._replace(depth_mm=1.0)  # type: ignore[call-arg]


@compiled
def _rounded(record: Tip) -> Tip:
    return record._replace(ticks=1.5)  # type: ignore[arg-type]


@compiled
def _other_record(record: Tip) -> Tip:
    return record._replace(place=1.0)  # type: ignore[arg-type]


@compiled
def _positional(record: Tip) -> Tip:
    return record._replace(1.0)  # type: ignore[arg-type, call-arg]


@jit
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_misspelt, "Tip has no field depth_mm"),
        (_rounded, "Tip.ticks is int64: float64 cannot replace it"),
        (_other_record, "Tip.place is Place.*: float64 cannot replace it"),
        (_positional, "Tip._replace takes keyword arguments only"),
    ],
)
def test_a_change_that_is_none_is_refused(change: Callable[[Tip], Any], message: str) -> None:
    with pytest.raises(TypingError, match=message):
        change(tip())


PROGRAM = """
import json
from tests.kernel.compiler.test_replacement import advance, tip
after = advance(tip(), 2.5)
hits = sum(advance.stats.cache_hits.values()) if hasattr(advance, "stats") else -1
print(json.dumps([after.place.depth_mm, bool(after.inside), hits]))
"""


def _in_another_process(cache: Path, disabled: str) -> Any:
    environment = {
        **os.environ,
        "OPENSUCTION_CACHE_DIR": str(cache),
        "NUMBA_DISABLE_JIT": disabled,
        "PYTHONPATH": os.pathsep.join((str(PACKAGE.parent), *sys.path)),
    }
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        env=environment,
        cwd=PACKAGE.parents[1],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def test_a_second_process_finds_the_machine_code(tmp_path: Path) -> None:
    assert _in_another_process(tmp_path, "0") == [3.5, True, 0]
    assert _in_another_process(tmp_path, "0") == [3.5, True, 1]


def test_plain_python_gives_the_same(tmp_path: Path) -> None:
    assert _in_another_process(tmp_path, "1") == [3.5, True, -1]
