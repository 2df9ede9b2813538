"""A task that one process has at a time: refused to a second one, free once the first dies."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from opensuction.ipc.liveness import ProcessLock, end_holder, holder
from opensuction.kernel.errors import InputError

HOLDER = (
    "import sys, time\n"
    "from pathlib import Path\n"
    "from opensuction.ipc.liveness import ProcessLock\n"
    "held = ProcessLock(Path(sys.argv[1]), 'a test runs')\n"
    "print('held', flush=True)\n"
    "time.sleep(60)\n"
)


def test_who_has_it_is_known_and_nobody_once_it_is_killed(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    assert holder(path) is None
    process = subprocess.Popen([sys.executable, "-c", HOLDER, str(path)], stdout=subprocess.PIPE)
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        assert holder(path) == process.pid
        with pytest.raises(InputError, match=f"a test runs already: process {process.pid}, by "):
            ProcessLock(path, "a test runs")
        assert holder(path) == process.pid, "to be refused takes nothing"
    finally:
        process.kill()
        process.communicate()
    assert holder(path) is None
    with ProcessLock(path, "a test runs"):
        assert path.exists()


def test_who_is_stopped_ends_only_where_it_may_be_killed(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    end_holder(path, 0.1)  # nobody has it
    process = subprocess.Popen([sys.executable, "-c", HOLDER, str(path)], stdout=subprocess.PIPE)
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        process.send_signal(signal.SIGSTOP)
        os.waitpid(process.pid, os.WUNTRACED)  # it stands now, and hears nothing more
        with pytest.raises(InputError, match=f"process {process.pid} of .* does not end"):
            end_holder(path, 0.1)
        assert holder(path) == process.pid
        end_holder(path, 0.1, kills=True)
        assert holder(path) is None
    finally:
        process.kill()
        process.communicate()


def test_a_folder_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written: No such file"):
        ProcessLock(tmp_path / "no" / "lock", "a test runs")
