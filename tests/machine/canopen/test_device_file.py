"""Device files: the one of the emulated drives, and what no machine can be driven by."""

import re
import tomllib
from pathlib import Path

import pytest
import tomli_w

from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import device_file
from opensuction.machine.canopen.objects import AbortConnection

TEXT = device_file.EMULATED.read_text(encoding="utf-8")
STOP = tomllib.loads(TEXT)["contact"]["stop"][0]


def load(tmp_path: Path, *changes: tuple[str, object]) -> str:
    """What the emulated drives' file is refused with after changes; a value of None leaves out."""
    given = tomllib.loads(TEXT)
    for key, value in changes:
        *sections, name = key.split(".")
        section = given
        for one in sections:
            section = section[one]
        if value is None:
            del section[name]
        else:
            section[name] = value
    path = tmp_path / device_file.NAME
    path.write_text(tomli_w.dumps(given), encoding="utf-8")
    with pytest.raises(InputError) as refused:
        device_file.find(tmp_path)
    message = str(refused.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message.removeprefix(f"{path}: ")


def test_the_emulated_drives_have_a_file() -> None:
    device = device_file.load(device_file.EMULATED)
    assert device.nodes == (1, 2, 3)
    assert device.insertion.counts_per_unit == 200.0
    assert device.insertion.most_rpm == 938
    assert device.insertion.lost_host == AbortConnection.WITHDRAW


def test_a_drive_that_counts_down_has_a_negative_scale(tmp_path: Path) -> None:
    path = tmp_path / "reversed.toml"
    path.write_text(TEXT.replace("reversed = false", "reversed = true", 1), encoding="utf-8")
    device = device_file.load(path)
    assert device.insertion.counts_per_unit == -200.0
    assert device.valve.counts_per_unit > 0.0
    assert device.insertion.most_rpm == 938


def test_a_folder_without_a_device_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no device file"):
        device_file.find(tmp_path)


@pytest.mark.parametrize("section", ["", "bus.", "insertion.", "insertion.encoder.", "module."])
def test_an_unknown_key_is_named_wherever_it_is(tmp_path: Path, section: str) -> None:
    assert load(tmp_path, (f"{section}nod", 1)).startswith(f"unknown key {section}nod")


def _keys(section: dict[str, object], head: str = "") -> list[str]:
    found = []
    for name, value in section.items():
        found.append(f"{head}{name}")
        if isinstance(value, dict):
            found += _keys(value, f"{head}{name}.")
    return found


def test_every_key_is_asked_for(tmp_path: Path) -> None:
    """None has a default."""
    for key in _keys(tomllib.loads(TEXT)):
        assert load(tmp_path, (key, None)).startswith(f"{key} is missing; give ")


def test_every_key_refuses_what_is_not_its_kind(tmp_path: Path) -> None:
    for key in _keys(tomllib.loads(TEXT)):
        for wrong in ([["x"]], {"x": 1}):
            assert key in load(tmp_path, (key, wrong))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ([("insertion.lost_host", "nothing")], "run on after the host has died; give 'withdraw'"),
        ([("valve.lost_host", "nothing")], "run on after the host has died"),
        ([("valve.lost_host", "hope")], "unknown valve.lost_host 'hope'"),
        ([("valve.node", 1)], "insertion.node and valve.node are both 1; give each participant"),
        ([("host_node", 3)], "host_node and module.node are both 3"),
        ([("valve.node", 1), ("module.node", 1)], "and module.node are all 1"),
        ([("module.node", 0)], "module.node is 0, below the limit of 1"),
        ([("module.node", 128)], "above the limit of 127"),
        ([("bus.period_s", 0.0025)], "whole ms"),
        ([("bus.period_s", 0.0001)], "below the limit of 0.001 s"),
        ([("bus.period_s", float("nan"))], "not a finite number"),
        ([("bus.interface", "")], "bus.interface is ''"),
        ([("insertion.encoder.gear_ratio", 0.0)], "exactly the limit of 0; give a number, above 0"),
        ([("insertion.encoder.counts_per_turn", 0)], "below the limit of 1"),
        ([("insertion.encoder.counts_per_turn", 64)], "coarser than 0.05 mm"),
        (
            [
                ("insertion.encoder.counts_per_turn", 1 << 24),
                ("insertion.encoder.gear_ratio", 100.0),
            ],
            "32 bits do not hold the range",
        ),
        ([("valve.encoder.travel_per_turn", 900.0)], "coarser than 0.005 rad"),
        ([("insertion.lowest", 500.0)], "insertion.lowest is 500, not below"),
        ([("insertion.lowest", 1.0)], "leave out 0"),
        ([("insertion.most_torque", 0.0)], "exactly the limit of 0"),
        ([("insertion.homing.method", 38)], "above the limit of 37"),
        ([("insertion.homing.method", -129)], "below the limit of -128"),
        ([("insertion.homing.at", 451.0)], "insertion.homing.at is 451, beyond the axis' range"),
        ([("insertion.homing.at", float("nan"))], "not a finite number"),
        ([("valve.homing.slow_per_s", 1.0)], "valve.homing has speeds of 0.5 and 1; give"),
        ([("insertion.homing.per_s", 161.0)], "give insertion.most_per_s of 160 at most"),
        ([("insertion.homing.per_s2", 0.0)], "exactly the limit of 0"),
        ([("insertion.following_window", -1.0)], "below the limit of 0"),
        (
            [("insertion.following_window", 9e3), ("insertion.encoder.gear_ratio", 9e3)],
            "following_window is 9000, more than 32 bits hold",
        ),
        ([("contact.wired_bit", 16)], "contact.closed_bit and contact.wired_bit are both 16"),
        ([("contact.wired_bit", 32)], "above the limit of 31"),
        ([("contact.stop", [])], "the motor would run on after contact; give the maker's objects"),
        ([("contact.stop", 0x2300)], "contact.stop is 8960, not a list of sections"),
        ([("contact.stop", [STOP, {}])], "contact.stop[2].object_index is missing"),
        ([("contact.stop", [{**STOP, "bits": 64}])], "contact.stop[1].bits is 64"),
        ([("contact.stop", [{**STOP, "bits": 16}])], "[1].value is 0x10000, which 16 bits do not"),
        ([("contact.stop", [{**STOP, "object_index": 0x6040}])], "above the limit of 24575"),
        ([("module.carriage.channel", 1)], "module.vacuum.channel and module.carriage.channel"),
        ([("module.vacuum.channel", 0)], "no machine does without"),
        ([("module.regulator.channel", 3)], "give an analogue output from 1 to 2"),
        ([("module.vacuum.counts_per_unit", 0.0)], "give at least 5"),
        ([("module.vacuum.counts_per_unit", 4000.0)], "16 bits hold no 200 mmHg"),
        ([("module.vacuum.zero_counts", 32000)], "16 bits hold no 200 mmHg"),
        ([("module.regulator.counts_per_unit", 0.0)], "module.regulator.counts_per_unit is 0"),
        ([("module.mouth_bit", 1)], "module.mouth_bit and module.monitor_bit are both 1"),
        ([("module.validity_bits", [2, 2, 4])], "are both 2; give each input a bit of its own"),
        ([("module.validity_bits", [2, 3])], "module.validity_bits"),
        ([("module.monitor_bit", -1)], "its value would never count"),
        ([("heartbeats.lost_host_ms", 12)], "a single heartbeat that is lost would lose the host"),
        ([("heartbeats.lost_node_ms", 40)], "would lose the node; give more than 44"),
        ([("heartbeats.host_ms", 2)], "less than a period of 4 ms"),
        ([("heartbeats.lost_host_ms", 100)], "above the limit of 99 ms"),
        ([("insertion.identity.vendor", 1 << 32)], "above the limit of 4294967295"),
    ],
)
def test_what_no_machine_can_be_driven_by_is_refused(
    tmp_path: Path, changes: list[tuple[str, object]], words: str
) -> None:
    assert re.search(re.escape(words), load(tmp_path, *changes))
