"""``drives`` as its users meet it: nodes that come on a bus, and leave it."""

import os
import signal
import time
from pathlib import Path

import pytest

from opensuction.cli.command.drives import DrivesOptions, drives
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import device_file
from opensuction.machine.canopen.frame_bus import open_bus
from opensuction.machine.canopen.objects import Communication
from opensuction.machine.canopen.stepped_network import SteppedNetwork
from tests.cli.command import begun, wait_for

pytestmark = pytest.mark.real_time

FILE = "Device file for a controller: "


def test_a_device_file_that_is_none_is_refused_before_anything_begins(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        drives(DrivesOptions(device=tmp_path / "none.toml"))


@pytest.mark.sweep
def test_any_master_finds_them_until_they_are_interrupted(tmp_path: Path) -> None:
    name = f"t{os.getpid()}-{time.monotonic_ns() % 10**9}"
    process = begun("drives", "--machine", "bench", "--name", name, cwd=tmp_path)
    said = wait_for("Ctrl-C takes them off the bus", process.stderr)
    (path,) = (Path(line[len(FILE) :]) for line in said.splitlines() if line.startswith(FILE))
    device = device_file.load(path)
    network = SteppedNetwork(
        open_bus(device.bus, THIS_COMPUTER, "master", tmp_path), THIS_COMPUTER.clock
    )
    for number in device.nodes:
        node = network.add_remote(number, timeout_s=5.0)
        assert node.sdo.upload(Communication.IDENTITY, 1) == bytes([1, 0, 0xAF, 0])
    network.disconnect()
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60.0)[1]
    assert process.returncode == 0, said
    assert "the drives are off the bus" in said
    assert not list(path.parent.iterdir())
    path.parent.rmdir()
