"""A ring is read whole or not at all, whoever dies when."""

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.ipc.ring import HASTE_ROWS, RingReader, RingWriter
from opensuction.kernel import slot
from opensuction.kernel.errors import InputError

COLUMNS = tuple(f"c{i}" for i in range(7))
SLOTS = 100


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "ring"


@pytest.fixture
def ring(path: Path) -> Iterator[RingWriter]:
    with RingWriter(path, COLUMNS, SLOTS, {"settings": "abc"}) as made:
        yield made


def row_of(number: int) -> np.ndarray:
    return np.array([float(number), -0.0, np.nan, 1e-320, np.inf, number * 0.1, 3.0])


def write(ring: RingWriter, first: int, last: int) -> None:
    for number in range(first, last + 1):
        assert ring.write(row_of(number)) == number


def bits(rows: np.ndarray) -> list[list[int]]:
    found: list[list[int]] = np.ascontiguousarray(rows).view(np.uint64).tolist()
    return found


def test_what_is_written_is_read_to_the_last_bit(path: Path, ring: RingWriter) -> None:
    reader = RingReader(path)
    assert reader.facts.columns == COLUMNS
    assert reader.facts.told == {"settings": "abc"}
    assert reader.snapshot() is None
    assert reader.read().rows.shape == (0, 7)
    write(ring, 1, 60)
    found = reader.read()
    assert (found.first, found.missed) == (1, 0)
    assert bits(found.rows) == bits(np.array([row_of(n) for n in range(1, 61)]))
    write(ring, 61, 130)
    first, second = reader.read(50), reader.read()
    assert (first.first, len(first.rows), second.first, len(second.rows)) == (61, 50, 111, 20)
    newest = reader.snapshot()
    assert newest is not None
    assert newest[0] == 130
    assert bits(newest[1]) == bits(row_of(130))


def test_a_reader_that_is_overtaken_is_told_what_it_missed(path: Path, ring: RingWriter) -> None:
    reader = RingReader(path)
    write(ring, 1, 10)
    reader.read()
    write(ring, 11, 350)
    found = reader.read()
    assert found.missed == 350 - SLOTS + 1 + HASTE_ROWS - 11
    assert found.first == 11 + found.missed
    assert found.rows[0, 0] == found.first
    assert found.rows[-1, 0] == 350.0
    assert reader.read().missed == 0


def test_of_a_dead_writer_all_that_is_whole_is_left(path: Path, ring: RingWriter) -> None:
    write(ring, 1, 250)
    # Killed in the middle of number 251: its slot is torn, 151 is gone.
    torn = ring.slots[251 % SLOTS]
    torn[0] = slot.EMPTY
    torn[3] = np.float64(251.0).view(np.uint64)
    reader = RingReader(path)
    reader.next = 1
    found = reader.drain()
    assert found.rows[:, 0].tolist() == [float(n) for n in range(152, 251)]
    assert found.missed == 151
    assert reader.drain().rows.shape == (0, 7)


@given(word=st.integers(0, len(COLUMNS) + 2), bit=st.integers(0, 63))
def test_no_flipped_bit_passes(word: int, bit: int) -> None:
    slots = np.zeros((4, len(COLUMNS) + slot.AROUND), np.uint64)
    row = np.empty(len(COLUMNS), np.uint64)
    number = np.uint64(6)
    slot.write(slots, number, row_of(6).view(np.uint64))
    assert slot.read(slots, number, row)
    slots[2, word] ^= np.uint64(1) << np.uint64(bit)
    assert not slot.read(slots, number, row)


def test_a_second_writer_is_refused_and_a_new_one_leaves_readers_what_they_had(
    path: Path, ring: RingWriter
) -> None:
    write(ring, 1, 5)
    with pytest.raises(InputError, match="written by another process"):
        RingWriter(path, COLUMNS, SLOTS, {})
    before = RingReader(path)
    ring.close()
    again = RingWriter(path, COLUMNS[:3], SLOTS, {})
    assert before.read().rows[:, 0].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert RingReader(path).facts.columns == COLUMNS[:3]
    again.close()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no ring at"),
        (b"short", "is not a ring"),
        (b"x" * 8192, "is not a ring"),
    ],
)
def test_what_is_no_ring_is_refused_in_a_line(path: Path, content: bytes, words: str) -> None:
    path.write_bytes(content)
    with pytest.raises(InputError, match=words):
        RingReader(path)
    with pytest.raises(InputError, match="no ring at"):
        RingReader(path.with_name("nowhere"))


def test_a_ring_that_was_cut_off_or_is_newer_is_refused(path: Path) -> None:
    RingWriter(path, COLUMNS, SLOTS, {}).close()
    whole = path.read_bytes()
    path.write_bytes(whole[:5000])
    with pytest.raises(InputError, match="cut off: 5000 bytes"):
        RingReader(path)
    path.write_bytes(whole[:8] + (2).to_bytes(8, "little") + whole[16:])
    with pytest.raises(InputError, match="of version 2; this software reads 1"):
        RingReader(path)


WRITER = """
import sys
from collections.abc import Iterator
from pathlib import Path
import numpy as np
from opensuction.ipc.ring import RingWriter
ring = RingWriter(Path(sys.argv[1]), ["a"] * 40, 50, {})
number = 0
while True:
    number += 1
    ring.write(np.full(40, float(number)))
    if number == 1:
        print("begun", flush=True)
"""


LOOKED_AT = 5_000
"""Rows that were read whole while the writer went on."""


def test_a_reader_beside_a_writer_at_full_speed_never_sees_half_a_row(path: Path) -> None:
    """A ring of 50 rows, overtaken all the time; then the writer is killed."""
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True
    )
    assert writer.stdout is not None
    assert writer.stdout.readline() == "begun\n"
    reader, seen, missed, ends = RingReader(path), 0, 0, time.monotonic() + 60.0
    while (seen < LOOKED_AT or missed == 0) and time.monotonic() < ends:
        found = reader.read()
        numbers = np.arange(found.first, found.first + len(found.rows), dtype=float)
        assert (found.rows == numbers[:, None]).all()
        seen, missed = seen + len(found.rows), missed + found.missed
    writer.kill()
    writer.communicate()
    left = reader.drain()
    assert (left.rows == left.rows[:, :1]).all()
    assert seen >= LOOKED_AT
    assert missed > 0
    assert seen + missed == reader.next - 1 - len(left.rows) - left.missed
