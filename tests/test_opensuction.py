"""The library's own names: there, typed, and loaded only when they are asked for."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import opensuction


@pytest.mark.parametrize("name", opensuction.__all__)
def test_every_name_is_there(name: str) -> None:
    assert getattr(opensuction, name) is not None


def test_type_checkers_are_told_of_every_name_and_where_it_is() -> None:
    stub = Path(opensuction.__file__).with_suffix(".pyi")
    assert stub.name == "__init__.pyi"
    imports = [
        one for one in ast.parse(stub.read_text("utf-8")).body if isinstance(one, ast.ImportFrom)
    ]
    told = {alias.asname: one.module for one in imports for alias in one.names}
    modules, rooms = vars(opensuction)["_MODULES"], vars(opensuction)["_ROOMS"]
    assert told == {
        **{name: f"opensuction.{where}" for name, where in modules.items()},
        **dict.fromkeys(rooms, "opensuction"),
    }
    assert set(opensuction.__all__) == {*told, "__version__"}


def test_a_name_that_is_not_there_is_missed_as_usual() -> None:
    with pytest.raises(AttributeError, match="module 'opensuction' has no attribute 'Kontroller'"):
        vars(opensuction)["__getattr__"]("Kontroller")
    assert not hasattr(opensuction, "Kontroller")


def test_to_import_it_loads_nothing_heavy() -> None:
    program = "import opensuction, sys; print(*sorted(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    loaded = set(done.stdout.split())
    assert "opensuction" in loaded
    assert not loaded & {"numba", "numpy", "scipy", "pydantic", "rich", "opensuction.kernel"}


FIRST_FIT = """
import sys
import numpy as np
import opensuction

x = np.cumsum(np.sin(np.arange(400) / 20.0))
lag = np.concatenate([[0.0], np.cumsum(np.diff(x) * np.exp(-0.1 * np.abs(np.diff(x))))])
opensuction.identify(x, lag + 0.3 * np.sign(np.gradient(x)), model="modified-dahl")
print(*sorted(sys.modules))
"""


def test_a_first_fit_loads_what_it_runs_and_no_more() -> None:
    # The first process may have to compile; what the second one needs is there then.
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", FIRST_FIT], capture_output=True, text=True, check=True
        )
    loaded = set(done.stdout.split())
    assert "opensuction.identification.workbench" in loaded
    heavy = {"linalg", "optimize", "signal", "sparse", "special", "stats"}
    assert not loaded & {f"scipy.{name}" for name in heavy}
    assert not loaded & {"pydantic", "rich"}
    # What numba can compile: to run machine code that is there it is not asked.
    assert not loaded & {"numba.np.arraymath", "numba.np.linalg", "numba.typed.typeddict"}


def test_a_person_who_looks_sees_every_name() -> None:
    assert set(opensuction.__all__) <= set(dir(opensuction))


def test_changelog_and_citation_name_this_version_and_one_day() -> None:
    root = Path(__file__).resolve().parents[1]
    released = re.findall(
        r"^## (\d+\.\d+\.\d+) - (\d{4}-\d{2}-\d{2})$",
        (root / "CHANGELOG.md").read_text("utf-8"),
        re.MULTILINE,
    )
    cited = (root / "CITATION.cff").read_text("utf-8")
    version, day = released[0]
    assert version == opensuction.__version__
    assert f"\nversion: {version}\n" in cited
    assert f"\ndate-released: {day}\n" in cited


def test_version_citation_and_changelog_name_the_same_release() -> None:
    root = Path(__file__).resolve().parents[1]
    citation = (root / "CITATION.cff").read_text("utf-8")
    version, date = (
        next(found[1] for found in re.finditer(f"(?m)^{key}: (.+)$", citation))
        for key in ("version", "date-released")
    )
    assert version == opensuction.__version__
    headings = re.findall("(?m)^## (.+)$", (root / "CHANGELOG.md").read_text("utf-8"))
    assert headings[:2] == ["Unreleased", f"{version} - {date}"]
