"""The faults that are planted for the tests of processes can still be planted."""

import re
from pathlib import Path

import pytest

from tools.mutation.planted import FAULTS, ROOT, SOURCES, Fault


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: str(fault.name))
def test_its_line_stands_once_and_its_test_is_there(fault: Fault) -> None:
    source = (ROOT / SOURCES / fault.file).read_text(encoding="utf-8")
    assert source.count(fault.sound) == 1
    file, _, name = fault.test.partition("::")
    test = Path(ROOT / file).read_text(encoding="utf-8")
    assert re.search(rf"^def {name}\(", test, re.MULTILINE)
    assert "real_time" in test or "simulated_room" in test
