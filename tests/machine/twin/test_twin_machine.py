"""The twin's process: what it refuses, whom it serves, what outlives whom."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.ipc.ring import RingWriter
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.machine.port import EVERYTHING, Capabilities
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_machine import TwinMachine, TwinTruth
from opensuction.machine.twin.twin_process import BEGUN, SHOWN, playing
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.simulation.machine_side import SHOWN_COLUMNS
from opensuction.twin.plant import PlantState
from tests.controller.bedside import at_bed

COMMAND = [sys.executable, "-m", "opensuction.machine.twin.twin_process"]


@pytest.mark.parametrize("content", [None, b"", b"nothing of the kind"])
def test_without_a_machine_to_play_it_says_so(tmp_path: Path, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / BEGUN).write_bytes(content)
    with pytest.raises(InputError, match="no machine to play in "), playing(tmp_path):
        pass


@pytest.mark.real_time
def test_a_process_that_cannot_play_ends_with_a_line(tmp_path: Path) -> None:
    (tmp_path / BEGUN).write_bytes(b"nothing of the kind")
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


def at_bench() -> tuple[Loop, LoopState]:
    rig = rigs.rig("bench", 1)
    known = rigs.uncalibrated(rig.profile)
    return rigs.assemble(rig, PAPER, CompensationKind.NONE, known, 2)


def without_monitor() -> tuple[Loop, LoopState]:
    loop, state = at_bed("neonate")
    patient = loop.machine.patient
    alone = patient._replace(monitor=patient.monitor._replace(present=False))
    return loop._replace(machine=loop.machine._replace(patient=alone)), state


@pytest.mark.parametrize(
    ("begun", "has"),
    [
        (at_bed("neonate"), EVERYTHING),
        (without_monitor(), EVERYTHING._replace(monitor=False)),
        (at_bench(), EVERYTHING._replace(monitor=False, mouth_barrier=False)),
    ],
    ids=["bed", "bed without a monitor", "bench"],
)
def test_it_has_what_is_at_its_place_and_tells_what_is_so(
    begun: tuple[Loop, LoopState], has: Capabilities, tmp_path: Path
) -> None:
    loop, state = begun
    side = twin_machine.side_of(loop, seed=1)
    twin_machine.prepare(tmp_path, side, PlantState(state.machine, state.bedside))
    with playing(tmp_path) as twin:
        truth = TwinTruth(tmp_path)
        assert truth.newest() is None
        for _ in range(3):
            twin.step(np.zeros(len(MESSAGE_COLUMNS)), new=False)
        port = TwinMachine(tmp_path)
        port.close()
        assert port.facts.capabilities == twin_machine.capabilities_of(tmp_path) == has
        found, newest = truth.read(), truth.newest()
        assert newest is not None
        assert list(found.rows[:, truth.columns.index("tick")]) == [0.0, 1.0, 2.0]
        assert (found.missed, truth.period_s) == (0, DT_S)
        np.testing.assert_array_equal(newest, twin.call.shown_row)
        assert len(truth.read().rows) == 0
        assert truth.built == side.machine
