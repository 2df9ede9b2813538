"""``python -m tools.mutation.planted [--busy]``: faults that tests of processes exist for, planted.

The tests run in real time or on a simulated computer. Each fault is put into a copy of the tree,
where its test must then fail: not pass, and not be left unjudged. With ``--busy`` one busy process
works on each core meanwhile. Exit 1 where a test missed its fault.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
SOURCES = Path("src", "opensuction")
COPIED = ("src", "tests", "docs", "pyproject.toml", "README.md")
"""Of the tree, as far as tests read it."""
BUSY = "while True: pass"
LONGEST_S = 600.0
RUNTIME, BROWSER = "tests/runtime", "tests/browser/console"


class Fault(NamedTuple):
    """A mistake in one line, and the test that must notice it."""

    name: str
    file: str
    """Below `SOURCES`."""
    sound: str
    """Stands once in the file."""
    broken: str
    test: str


FAULTS = (
    Fault(
        "the drives' watchdog never fires",
        "twin/machine/fail_safe.py",
        "silent > watchdog.silence_s + 0.5 * dt_s",
        "silent > 1e9",
        f"{RUNTIME}/test_control_process.py"
        "::test_killed_in_the_airway_the_drives_bring_it_out_and_the_next_one_waits_for_a_person",
    ),
    Fault(
        "a process that is silent is never missed",
        "ipc/liveness.py",
        "return age_ns / NS_PER_S if last",
        "return 0.0 if last",
        f"{RUNTIME}/test_recorder_process.py"
        "::test_killed_it_is_missed_and_another_goes_on_where_it_was",
    ),
    Fault(
        "a hung process is not replaced",
        "runtime/supervisor.py",
        "if watched_s > allowed_s and self._heartbeat",
        "if watched_s > 1e9 and self._heartbeat",
        f"{RUNTIME}/test_supervisor.py"
        "::test_what_stands_still_is_replaced_and_the_catheter_comes_out",
    ),
    Fault(
        "the answer to a button never comes",
        "ipc/mailbox.py",
        "        answers.append(answer(asked, verdict))\n",
        "        return\n",
        "tests/console/test_server.py::test_a_body_that_does_not_come_is_not_waited_for",
    ),
    Fault(
        "the loop does not hear a stop",
        "ipc/mailbox.py",
        "dict.fromkeys(down, True)",
        "dict.fromkeys(down - {STOP}, True)",
        f"{BROWSER}/test_setup_page.py::test_stop_ends_teaching_at_any_step",
    ),
    Fault(
        "ticks that were missed are caught up",
        "ipc/deadline_scheduler.py",
        "        self.deadline_ns += missed * self.period_ns\n"
        "        self.skipped += missed\n"
        "        return missed\n",
        "        return 0\n",
        "tests/ipc/test_deadline_scheduler.py::test_a_missed_tick_is_skipped_and_never_caught_up",
    ),
    Fault(
        "a body is waited for for ever",
        "console/guard/body.py",
        "asyncio.timeout(limits.body_s)",
        "asyncio.timeout(None)",
        "tests/console/test_server.py::test_a_body_that_does_not_come_is_not_waited_for",
    ),
    Fault(
        "the page never says that the connection is lost",
        "console/page/js/live.js",
        "const link = this.judge(silent_ms);",
        "const link = this.judge(0);",
        f"{BROWSER}/test_alarm_bar.py::test_a_lost_connection_is_shown_within_two_seconds",
    ),
    Fault(
        "START goes on before it was held for a second",
        "console/page/js/bedside/start.js",
        "const HOLD_MS = 1000;",
        "const HOLD_MS = 100;",
        f"{BROWSER}/test_bedside_page.py::test_start_is_held_by_finger_or_key",
    ),
    Fault(
        "drives obey a controller that has not started anew",
        "simulation/machine_side.py",
        "counts[GREETED] == 0",
        "counts[GREETED] == 2",
        "tests/conformance/test_port.py"
        "::test_a_machine_that_was_started_again_is_read_again_and_obeys_who_starts_anew",
    ),
    Fault(
        "a controller that is told to end ends with the tip inside",
        "runtime/control_process.py",
        "while not ((ending := host.terminations()) and loop.is_resting)",
        "while not (ending := host.terminations())",
        f"{RUNTIME}/test_control_process.py::test_told_to_end_in_a_cycle_it_comes_out_first",
    ),
)


@contextmanager
def planted(fault: Fault) -> Iterator[Path]:
    """A copy of the tree with the fault in it. Raises ValueError where its line is not there."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name in COPIED:
            whole = (ROOT / name).is_dir()
            (shutil.copytree if whole else shutil.copy)(ROOT / name, root / name)
        path = root / SOURCES / fault.file
        text = path.read_text(encoding="utf-8")
        if text.count(fault.sound) != 1:
            raise ValueError(f"{fault.file}: not once there: {fault.sound!r}")
        path.write_text(text.replace(fault.sound, fault.broken), encoding="utf-8")
        yield root


def outcome(fault: Fault) -> str:
    """Outcome of a fault's test with the fault: ``failed`` where the test notices it."""
    with planted(fault) as root:
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", fault.test]
        environment = {**os.environ, "PYTHONPATH": str(root / "src")}
        ran = subprocess.run(
            [*command, "-p", "no:benchmark"],
            cwd=root,
            env=environment,
            capture_output=True,
            text=True,
            timeout=LONGEST_S,
            check=False,
        )
    summary = ran.stdout.strip().splitlines()[-1]
    if ran.returncode == 1 and " failed" in f" {summary}":
        return "failed"
    return f"missed it: {summary}"


@contextmanager
def busy(is_busy: bool) -> Iterator[None]:
    """One busy process on each core, for as long as this lasts."""
    count = len(os.sched_getaffinity(0)) if is_busy else 0
    processes = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(count)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def main() -> int:
    """Plant each of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--busy", action="store_true", help="one busy process on each core")
    chosen = parser.parse_args()
    found = []
    with busy(chosen.busy):
        for fault in FAULTS:
            begun_s = time.monotonic()
            found.append(outcome(fault))
            seconds = time.monotonic() - begun_s
            sys.stdout.write(f"{fault.name}: {found[-1]} ({seconds:.0f} s)\n")
            sys.stdout.flush()
    return int(any(one != "failed" for one in found))


if __name__ == "__main__":
    sys.exit(main())
