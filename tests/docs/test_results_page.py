"""Keys that the tests of the commands promise are explained in `docs/reference/results.md`."""

import re
from pathlib import Path

import pytest

from tests.cli import (
    test_benchmark,
    test_calibrate,
    test_cycle,
    test_identify,
    test_reproduce,
    test_safety_case,
    test_trial,
)

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "results.md"
SECTIONS = dict(re.findall(r"^## (\S+)\n(.*?)(?=^## |\Z)", PAGE.read_text("utf-8"), re.M | re.S))


@pytest.mark.parametrize(
    ("command", "keys"),
    [
        ("cycle", test_cycle.KEYS),
        ("identify", test_identify.KEYS),
        ("calibrate", test_calibrate.KEYS),
        ("reproduce", test_reproduce.CLAIM_KEYS),
        ("benchmark", test_benchmark.KEYS),
        ("safety-case", test_safety_case.KEYS),
        ("trial", test_trial.KEYS),
    ],
)
def test_every_promised_key_is_explained(command: str, keys: set[str]) -> None:
    explained = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]*)`", SECTIONS[command]))))
    assert keys <= explained
