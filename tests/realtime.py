"""Which tests go by the clock of the wall, so that no two of them share the computer.

A machine in real time is a twin, a controller, a recorder and a console: processes that are late
where as many others run, and then do what they should when late. One such file runs at a time; the
other workers meanwhile take files that only compute.
"""

from typing import TYPE_CHECKING

from xdist.scheduler import LoadFileScheduling

if TYPE_CHECKING:
    from xdist.workermanage import WorkerController

FILES = (
    "tests/browser/",
    "tests/cli/test_ending.py",
    "tests/cli/test_inject.py",
    "tests/cli/test_run.py",
    "tests/conformance/test_port.py",
    "tests/console/load/",
    "tests/console/setup/test_teaching_api.py",
    "tests/console/signals/test_feed.py",
    "tests/console/test_console_process.py",
    "tests/console/test_server.py",
    "tests/devices/test_twin_machine.py",
    "tests/devices/test_witness.py",
    "tests/exchange/test_pace.py",
    "tests/runtime/test_control_process.py",
    "tests/runtime/test_disk.py",
    "tests/runtime/test_faults.py",
    "tests/runtime/test_kills.py",
    "tests/runtime/test_recorder_process.py",
    "tests/runtime/test_supervisor.py",
    "tests/runtime/test_wall_clock.py",
    "tests/runtime/timing/",
)
"""How their names begin."""


def is_realtime(nodeid: str) -> bool:
    """Whether a test, or all tests of a file, go by the clock of the wall."""
    return nodeid.startswith(FILES)


class OneAtATime(LoadFileScheduling):  # type: ignore[misc]  # it has no types
    """Hands files out in their order, but no second one of `FILES` while a first is at work.

    Once their turn has come there is always one at work: they wait much and compute little, and
    none of them is left for the end, when nothing is there to be done beside it.
    """

    _has_come = False

    def _assign_work_unit(self, node: "WorkerController") -> None:
        """The next file for a worker; where nothing else is left, one that will have to wait."""
        others = (work for worker, work in self.assigned_work.items() if worker != node)
        taken = any(
            is_realtime(file) and not all(tests.values())
            for work in others
            for file, tests in work.items()
        )
        self._has_come = self._has_come or is_realtime(next(iter(self.workqueue)))
        if self._has_come:
            fitting = (file for file in self.workqueue if is_realtime(file) != taken)
            first = next(fitting, None)
            if first is not None:
                self.workqueue.move_to_end(first, last=False)
        super()._assign_work_unit(node)
