"""Whoever writes is killed at any instant: what was answered is there, and the trail is whole."""

import signal

import pytest

from opensuction.records.entry import CycleEnd, Outcome
from opensuction.records.records import Records
from tests.records.conftest import on_both
from tests.records.writer import begin_writer

DEAD = CycleEnd(Outcome.INTERRUPTED, "the program was killed", None)
MAKING = (1, 5, 12, 30, 56, 80)
"""Statements while a new database is made, the commits among them (PostgreSQL 56, SQLite 80)."""
WRITING = range(8, 48, 5)
"""Statements while an old one is opened and cycles are begun and ended."""


def check(url: str, answered: list[str]) -> None:
    """As the supervisor does after a crash."""
    with Records.open(url) as records:
        assert records.audit().broken is None
        for left in records.unfinished_cycles():
            records.end_cycle(left.id, DEAD)
        for cycle in answered:
            assert records.find_end(cycle) is not None, "the cycle's record exists"
        assert records.unfinished_cycles() == []
        assert records.audit().broken is None


def kill_before(url: str, statement: int, cycles: int) -> list[str]:
    writer = begin_writer(url, "M-1", cycles, statement)
    said = writer.wait()
    assert writer.process.exitcode == -signal.SIGKILL
    return said


@pytest.mark.parametrize(
    "statement",
    [pytest.param(one, marks=() if i % 2 else pytest.mark.sweep) for i, one in enumerate(MAKING)],
)
def test_killed_while_a_database_is_made(empty_url: str, statement: int) -> None:
    check(empty_url, kill_before(empty_url, statement, 2))


@pytest.mark.sweep
def test_killed_while_cycles_are_written(url: str) -> None:
    answered: list[str] = []
    check(url, answered)
    for statement in WRITING:
        answered += kill_before(url, statement, 3)
        check(url, answered)
    assert answered


@on_both
def test_killed_from_outside(url: str) -> None:
    answered: list[str] = []
    for after in (1, 4, 9):
        writer = begin_writer(url, "M-1", 1000)
        answered += [writer.read() for _ in range(after)]
        writer.process.kill()
        answered += writer.wait()
        check(url, answered)
