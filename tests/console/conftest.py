"""A console for each test that asks for one; its people sign in once for all tests of a file."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.console.served import Served, served


@pytest.fixture
def console(tmp_path: Path) -> Iterator[Served]:
    with served(tmp_path) as made:
        yield made
