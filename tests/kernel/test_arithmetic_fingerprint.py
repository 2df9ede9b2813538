import os
import re
import subprocess
import sys

import numpy as np
import pytest

from opensuction.kernel import arithmetic_fingerprint, compiled
from opensuction.kernel.arithmetic_fingerprint import FUNCTIONS, POINTS, fingerprint
from tests.kernel.another_arithmetic import ANOTHER_WAY, takes_another_way

EXACT = {
    *("ceil", "copysign", "fabs", "floor", "fmod", "isclose", "isfinite", "isinf", "isnan"),
    *("inf", "nan", "pi", "tau", "radians", "degrees", "trunc"),
}
"""Of ``math``: what has one right result, and constants."""


def test_it_asks_every_library_function_that_the_core_calls() -> None:
    called = {
        name
        for room in compiled.CORE_ROOMS
        for source in (compiled.PACKAGE / room).rglob("*.py")
        for name in re.findall(r"\bmath\.([a-z0-9]+)", source.read_text(encoding="utf-8"))
    }
    assert called - EXACT <= set(FUNCTIONS)


def test_every_result_is_a_number_of_its_own() -> None:
    table = np.zeros((len(FUNCTIONS), POINTS))
    arithmetic_fingerprint._fill(table)
    assert np.isfinite(table).all()
    for name, row in zip(FUNCTIONS, table, strict=True):
        assert len(np.unique(row)) > 0.99 * POINTS, name


def test_it_is_the_same_each_time_and_sixteen_digits() -> None:
    assert re.fullmatch("[0-9a-f]{16}", fingerprint())
    assert fingerprint.__wrapped__() == fingerprint()


def _elsewhere(**environment: str) -> str:
    """The fingerprint in a process of its own."""
    script = (
        "from opensuction.kernel.arithmetic_fingerprint import fingerprint; print(fingerprint())"
    )
    ran = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, **environment},
        check=True,
        capture_output=True,
        text=True,
    )
    return ran.stdout.strip()


@pytest.mark.skipif(
    not takes_another_way(), reason="needs glibc and a processor that has AVX2 and FMA"
)
def test_a_library_that_takes_another_way_is_known_by_it() -> None:
    assert _elsewhere() == fingerprint()
    assert _elsewhere(**ANOTHER_WAY) != fingerprint()
