"""The twin's process: what it refuses, whom it serves, what outlives whom."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from opensuction.ipc.ring import RingWriter
from opensuction.kernel.errors import InputError
from opensuction.machine.twin.twin_machine import TwinMachine
from opensuction.machine.twin.twin_process import SHOWN
from opensuction.simulation.machine_side import SHOWN_COLUMNS

pytestmark = pytest.mark.real_time

COMMAND = [sys.executable, "-m", "opensuction.machine.twin.twin_process"]


@pytest.mark.parametrize("content", [None, b"", b"nothing of the kind"])
def test_without_a_machine_to_play_it_says_so_in_a_line(
    tmp_path: Path, content: bytes | None
) -> None:
    if content is not None:
        (tmp_path / "machine.npz").write_bytes(content)
    found = subprocess.run([*COMMAND, str(tmp_path)], capture_output=True, text=True, check=False)
    assert found.returncode == 1
    assert found.stderr.startswith("opensuction: no machine to play in ")
    assert found.stderr.count("\n") == 1


def test_where_no_twin_plays_a_controller_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no ring at"):
        TwinMachine(tmp_path)
    with (
        RingWriter(tmp_path / SHOWN, ("something", "else"), 10, {}),
        pytest.raises(InputError, match="another version of the twin"),
    ):
        TwinMachine(tmp_path)


def test_one_machine_has_one_controller(tmp_path: Path) -> None:
    told = {"version": "1", "most": "{}"}
    with RingWriter(tmp_path / SHOWN, SHOWN_COLUMNS, 10, told) as ring:
        ring.write(np.arange(float(len(SHOWN_COLUMNS))))
        first = TwinMachine(tmp_path)
        with pytest.raises(InputError, match="written by another process"):
            TwinMachine(tmp_path)
        readings = np.zeros(sum(name.startswith("readings.") for name in SHOWN_COLUMNS))
        assert first.read(readings) == 1
        assert readings[0] == SHOWN_COLUMNS.index("readings.head_mm")
        first.close()
        TwinMachine(tmp_path).close()
