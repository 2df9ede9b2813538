"""``drives`` as its users meet it: nodes that come on a bus, and leave it."""

import json
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.cli.command.drives import DrivesOptions, drives
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.canopen import device_file
from opensuction.machine.canopen.frame_bus import open_bus
from opensuction.machine.canopen.objects import Communication
from opensuction.machine.canopen.stepped_network import SteppedNetwork
from opensuction.runtime import controller_memory, machine_folder, nonvolatile_memory
from opensuction.session.running import machine
from tests.cli.command import begun, opensuction, wait_for

pytestmark = pytest.mark.real_time

NEONATE = ("--patient", "neonate")
FILE = "Device file for a controller: "


def own_name() -> str:
    """Name that no other machine has."""
    return f"t{os.getpid()}-{time.monotonic_ns() % 10**9}"


@pytest.mark.parametrize("contact_stop", [None, "object_index = 0x2301"])
def test_a_device_file_by_which_no_drives_are_made_is_refused_before_anything_begins(
    tmp_path: Path, contact_stop: str | None
) -> None:
    file, name = tmp_path / "mine.toml", own_name()
    if contact_stop is not None:
        text = device_file.EMULATED.read_text(encoding="utf-8")
        file.write_text(text.replace("object_index = 0x2300", contact_stop), encoding="utf-8")
    with pytest.raises(InputError):
        drives(DrivesOptions(device=file, drives_name=name))
    assert not machine_folder.find(name).exists()


@pytest.fixture(scope="module")
def drives_file(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Device file, for a controller, of drives that play until they are interrupted."""
    cwd = tmp_path_factory.mktemp("drives")
    process = begun("drives", *NEONATE, "--name", own_name(), cwd=cwd)
    said = wait_for("Ctrl-C takes them off the bus", process.stderr)
    (path,) = (Path(line[len(FILE) :]) for line in said.splitlines() if line.startswith(FILE))
    yield path
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60.0)[1]
    assert process.returncode == 0, said
    assert "the drives are off the bus" in said
    assert not list(path.parent.iterdir())
    path.parent.rmdir()


@pytest.mark.sweep
def test_any_master_finds_them(drives_file: Path, tmp_path: Path) -> None:
    device = device_file.load(drives_file)
    network = SteppedNetwork(
        open_bus(device.bus, THIS_COMPUTER, "master", tmp_path), THIS_COMPUTER.clock
    )
    for number in device.nodes:
        node = network.add_remote(number, timeout_s=5.0)
        assert node.sdo.upload(Communication.IDENTITY, 1) == bytes([1, 0, 0xAF, 0])
    network.disconnect()


@pytest.mark.sweep
def test_a_cycle_is_run_over_the_bus_recorded_and_replayed(
    drives_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    name = own_name()
    ran = opensuction(
        *("run", *NEONATE, "--device", str(drives_file), "--name", name, "--json"),
        *("--database", "ward.db", "--out", "kept"),
        cwd=tmp_path,
    )
    data = json.loads(ran.stdout)
    (cycle,) = data["cycles"]
    assert (cycle["outcome"], cycle["detail"]) == ("completed", ""), ran.stderr
    assert ran.returncode == 0
    assert not data["alarms"]
    assert data["in_silico"] is True
    assert data["device"] == "emulated"
    recording = tmp_path / "kept" / cycle["recording"]
    replayed = opensuction("replay", str(recording), "--json", cwd=tmp_path)
    assert json.loads(replayed.stdout)["identical"] is True
    folder = machine_folder.find(name)
    kept = controller_memory.read_before(folder)
    assert kept is not None  # for the next controller
    on_disk = nonvolatile_memory.recall(machine.memory_of(name), time.time_ns(), 0.0)
    assert on_disk is not None  # and for one after a loss of power
    assert on_disk.kept.episode.passes == kept.kept.episode.passes == 1
    assert on_disk.kept.episode.rest_left_s >= kept.kept.episode.rest_left_s > 0.0
    assert on_disk.phase == kept.phase == Phase.PARKED
    machine_folder.clear(folder)
    folder.rmdir()
