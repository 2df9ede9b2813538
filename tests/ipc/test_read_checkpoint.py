"""Mark of a reader's progress: it outlives the reader, and is never taken for another run's."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.ipc.ring import Place, ReadCheckpoint

NUMBERS = st.integers(0, 2**62)


def test_nothing_is_known_before_the_first(tmp_path: Path) -> None:
    assert ReadCheckpoint(tmp_path / "mark").find("run") is None


@given(name=st.text(), other=st.text(), row=NUMBERS, event=NUMBERS)
def test_the_next_reader_finds_the_place_of_its_run_only(
    tmp_path_factory: pytest.TempPathFactory, name: str, other: str, row: int, event: int
) -> None:
    path = tmp_path_factory.mktemp("mark") / "mark"
    ReadCheckpoint(path).set(name, Place(row, event))
    again = ReadCheckpoint(path)
    assert again.find(name) == Place(row, event)
    assert other == name or again.find(other) is None
