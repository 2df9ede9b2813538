"""Records of the core as C sees them."""

import ctypes
import subprocess
from pathlib import Path
from typing import Annotated, NamedTuple

import pytest
from annotated_types import Len

from benchmarks.native import layout
from tests.conftest import Component

Triple = Annotated[tuple[float, ...], Len(3, 3)]


class Inner(NamedTuple):
    held: bool
    tip_mm: float


class Outer(NamedTuple):
    on: bool
    ticks: int
    inner: Inner
    plays_mm: Triple
    pair: tuple[int, int]


OUTER = Outer(True, 7, Inner(True, 0.1), (1.0, 2.0, 4.0), (16, 32))
LIMIT = 0.3
SUM = 7 + 0.1 + 1.0 + 2.0 + 4.0 + 16 + 32 + LIMIT  # in the order of the C source
SOURCE = """
#include "records.h"
double sum(const Outer *outer)
{
    double total = outer->ticks;
    if (outer->on && outer->inner.held)
        total += outer->inner.tip_mm;
    for (int j = 0; j < PLAYS; j++)
        total += outer->plays_mm[j];
    return total + outer->pair[0] + outer->pair[1] + LIMIT;
}
"""


def compile_source(source: str, compiler: Path, folder: Path) -> subprocess.CompletedProcess[str]:
    header = layout.write_header((Outer,), {"PLAYS": 3, "LIMIT": LIMIT})
    (folder / "records.h").write_text(header)
    (folder / "sum.c").write_text(source)
    command = [str(compiler), "-std=c11", "-fPIC", "-shared", "-o", "sum.so", "sum.c"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_c_reads_every_kind_of_field_by_its_name(component: Component, tmp_path: Path) -> None:
    finished = compile_source(SOURCE, component("gcc"), tmp_path)
    assert finished.returncode == 0, finished.stderr
    library = ctypes.CDLL(str(tmp_path / "sum.so"))
    library.sum.restype = ctypes.c_double
    packed = layout.pack(OUTER)
    assert library.sum(ctypes.c_void_p(packed.ctypes.data)) == SUM


def test_a_field_that_the_record_no_longer_has_is_named(
    component: Component, tmp_path: Path
) -> None:
    finished = compile_source(SOURCE.replace("tip_mm", "depth_mm"), component("gcc"), tmp_path)
    assert finished.returncode != 0
    assert "depth_mm" in finished.stderr


class Named(NamedTuple):
    name: str


class Uneven(NamedTuple):
    values: tuple[float, ...]


@pytest.mark.parametrize(("record", "field"), [(Named, "Named.name"), (Uneven, "Uneven.values")])
def test_a_field_without_a_layout_in_c_is_refused_by_name(record: type, field: str) -> None:
    with pytest.raises(TypeError, match=field):
        layout.layout(record)
