"""Both stages of a run come to one end."""

import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from tests.stage import summary


@pytest.mark.parametrize(
    ("statuses", "expected"), [([0, 0], 0), ([5, 0], 0), ([5, 5], 5), ([0, 1], 1), ([1, 0], 1)]
)
def test_a_stage_without_a_test_fails_nothing(statuses: list[int], expected: int) -> None:
    assert summary.status(statuses) == expected


def test_both_stages_end_in_one_line() -> None:
    counts = Counter(passed=8976, failed=2, error=0, skipped=1)
    line = summary.line(counts, 1575.58)
    assert line.strip("= ") == "2 failed, 8976 passed, 1 skipped in 1575.58s (0:26:16)"
    assert "no tests ran in" in summary.line(Counter(), 1.0)


FAILING = """
import pytest

@pytest.mark.parametrize("number", range(3))
def test_in_a_browser(number):
    pytest.skip("chromium is not installed")

@pytest.mark.skipif(True, reason="for root alone")
def test_as_root():
    pass

@pytest.fixture(scope="session")
def browser():
    yield
    raise OSError("the browser is gone\\nfor good")

def test_a_wrong_sum(browser):
    assert 1 + 1 == 3

def test_the_last_of_its_process():
    pass
"""


def test_what_was_skipped_for_one_reason_is_one_line() -> None:
    reasons = Counter({"for root alone": 1, "chromium is not installed": 128})
    assert summary.skips(reasons) == [
        "SKIPPED 128: chromium is not installed",
        "SKIPPED 1: for root alone",
    ]


def test_each_end_is_told_with_its_reason_in_one_line(tmp_path: Path) -> None:
    file, result = tmp_path / "test_failing.py", tmp_path / "result.json"
    file.write_text(FAILING)
    plugin = ("-p", "tests.stage.plugin", "-p", "no:cacheprovider", f"--rootdir={tmp_path}")
    command = [sys.executable, "-m", "pytest", "-p", "xdist", "-n", "1", *plugin, str(file)]
    environment = {**os.environ, summary.RESULT: str(result)}
    for variable in [name for name in environment if name.startswith("PYTEST")]:
        del environment[variable]
    environment["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # schemathesis takes seconds
    subprocess.run(command, env=environment, capture_output=True, check=False)
    told = json.loads(result.read_text())
    assert told["skipped"] == {"chromium is not installed": 3, "for root alone": 1}
    assert told["failed"] == [
        "FAILED test_failing.py::test_a_wrong_sum: assert (1 + 1) == 3",
        "ERROR test_failing.py::test_the_last_of_its_process at teardown: "
        "OSError: the browser is gone for good",
    ]
