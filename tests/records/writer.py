"""A program that writes records, and may be killed as it does.

It prints the id of each cycle once its request was answered: that one must never be lost.
"""

import os
import signal
import sys

from sqlalchemy import Engine, event

from opensuction.records.records import Records
from tests.records.example import CLOGGED, COMPLETED, MACHINE, start


def kill_before(statement: int) -> None:
    """Be killed before the statement of this number, from 1 on, whatever it is."""
    left = statement

    def count(*_: object) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    for kind in ("before_cursor_execute", "commit"):
        event.listen(Engine, kind, count)


def write(url: str, machine: str, cycles: int) -> None:
    """Write so many cycles of a machine, each with an alarm."""
    with Records.open(url, wait_s=60.0) as records:
        for left in records.unfinished_cycles():
            if left.machine == machine:
                records.end_cycle(left.id, COMPLETED)
        for number in range(cycles):
            cycle = records.begin_cycle(start(machine=machine, catheter=f"{machine}-{number}"))
            print(cycle, flush=True)  # noqa: T201 - read by the test
            records.add_alarm(MACHINE._replace(serial=machine), CLOGGED, cycle)
            records.end_cycle(cycle, COMPLETED)


if __name__ == "__main__":
    if len(sys.argv) > 4:
        kill_before(int(sys.argv[4]))
    write(sys.argv[1], sys.argv[2], int(sys.argv[3]))
