"""A program that writes records, and may be killed as it does.

It says the id of each cycle once its request was answered: that one must never be lost.
"""

import multiprocessing
import os
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import NamedTuple

from sqlalchemy import Engine, event

from opensuction.records.records import Records
from tests.records.example import CLOGGED, COMPLETED, MACHINE, start

PROGRAMS = multiprocessing.get_context("forkserver")
PROGRAMS.set_forkserver_preload([__name__])
"""Each program is a process of its own, forked from one that has imported what all need."""
LASTS_S = 300.0
"""Only one that hangs works for so long."""


class Writer(NamedTuple):
    """A program that runs."""

    process: multiprocessing.process.BaseProcess
    said: Connection

    def read(self) -> str:
        """The id that it says next. Raises EOFError where it has ended."""
        assert self.said.poll(LASTS_S), "it says nothing any more"
        cycle: str = self.said.recv()
        return cycle

    def wait(self) -> list[str]:
        """Wait for its end; returns what it had still to say."""
        rest = []
        try:
            while True:
                rest.append(self.read())
        except EOFError:
            self.said.close()
        self.process.join(LASTS_S)
        return rest


def begin_writer(url: str, machine: str, cycles: int, killed_before: int = 0) -> Writer:
    """Start a writer of so many cycles.

    killed_before: number, from 1 on, of the statement before which it is killed; 0: of none.
    """
    said, says = PROGRAMS.Pipe(duplex=False)
    process = PROGRAMS.Process(target=_run, args=(url, machine, cycles, killed_before, says))
    process.start()
    says.close()
    return Writer(process, said)


def _run(url: str, machine: str, cycles: int, killed_before: int, says: Connection) -> None:
    if killed_before:
        _kill_before(killed_before)
    _write(url, machine, cycles, says.send)


def _kill_before(statement: int) -> None:
    """Be killed before the statement of this number, from 1 on, whatever it is."""
    left = statement

    def count(*_: object) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    for kind in ("before_cursor_execute", "commit"):
        event.listen(Engine, kind, count)


def _write(url: str, machine: str, cycles: int, say: Callable[[str], None]) -> None:
    """Write so many cycles of a machine, each with an alarm."""
    with Records.open(url, wait_s=60.0) as records:
        for left in records.unfinished_cycles():
            if left.machine == machine:
                records.end_cycle(left.id, COMPLETED)
        for number in range(cycles):
            cycle = records.begin_cycle(start(machine=machine, catheter=f"{machine}-{number}"))
            say(cycle)
            records.add_alarm(MACHINE._replace(serial=machine), CLOGGED, cycle)
            records.end_cycle(cycle, COMPLETED)
