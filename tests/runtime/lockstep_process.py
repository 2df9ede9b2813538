"""Controller and twin in one process, tick by tick: a machine that no busy computer can halt.

``python -m tests.runtime.lockstep_process DIR PERIOD_NS``. The controller is the real one, with the
files of its folder; the machine moves a tick when it is commanded, so neither is ever late for the
other. It is for tests of what stands before a machine, of which how it keeps time is not the point.
"""

import os
import sys
from pathlib import Path

import numpy as np

from opensuction.host import this_computer
from opensuction.host.host import Host, Steps
from opensuction.ipc.deadline_scheduler import DeadlineScheduler
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.kernel.record import Array
from opensuction.machine.port import MachineFacts
from opensuction.machine.twin.twin_machine import READINGS
from opensuction.machine.twin.twin_process import TwinPlayer, capabilities, most_obeyed, playing
from opensuction.runtime import control_process
from opensuction.simulation.closed_loop import DT_S
from opensuction.twin.machine import fail_safe

RATE = 3
"""Times as fast as a machine is that keeps time."""


class LockstepTwin:
    """A `ports.Port` to a twin that moves a tick with each command."""

    def __init__(self, twin: TwinPlayer) -> None:
        most = most_obeyed(twin.call)
        has = capabilities(twin.call)
        self.facts = MachineFacts("lockstep twin", "", True, DT_S, fail_safe.SILENCE_S, most, has)
        self._twin, self._number = twin, 0
        twin.step(np.zeros(len(MESSAGE_COLUMNS)), new=False)

    def read(self, readings: Array) -> int:
        """See `ports.Port.read`."""
        readings[:] = self._twin.call.shown_row[READINGS]
        return 1 + self._number

    def write(self, sent: Array) -> None:
        """See `ports.Port.write`."""
        self._twin.step(sent, new=True)
        self._twin.faults.look()
        self._number += 1

    def close(self) -> None:
        """See `ports.Port.close`."""


class LenientPace(DeadlineScheduler):
    """Ticks `RATE` times as often as they should be, later on a busy computer: none is missed."""

    def __init__(self, period_ns: int, now_ns: int) -> None:
        # Beside it others have work to do: it may be late, and they need not.
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        super().__init__(period_ns // RATE, now_ns)

    def begin(self, now_ns: int) -> int:
        """See `DeadlineScheduler.begin`."""
        super().begin(now_ns)
        return 0


def steps(host: Host, folder: Path, period_ns: int) -> Steps[None]:
    """Play and control until the process is told to end."""
    with playing(folder, host) as twin:
        attached = LockstepTwin(twin)
        yield from control_process.steps(host, folder, period_ns, lambda *_: attached, LenientPace)


if __name__ == "__main__":
    _folder, _period_ns = Path(sys.argv[1]), int(sys.argv[2])
    this_computer.run(lambda host: steps(host, _folder, _period_ns))
