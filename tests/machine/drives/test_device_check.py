"""Check of a machine: before emulated drives that are as the device file says, and others."""

from typing import TypeVar

import pytest

from opensuction.host.host import Steps, finish
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import device_check
from opensuction.machine.canopen.device import AxisMode, Device
from opensuction.machine.canopen.device_check import DeviceCheck
from opensuction.result.device_check_result import MoveFound
from tests.machine.canopen.stepped_bus import stepped_host
from tests.machine.drives.emulated_bench import DEVICE, EmulatedBench

Result = TypeVar("Result")


class Checked:
    """A check that lets the drives play while it sleeps."""

    def __init__(self, device: Device = DEVICE) -> None:
        """device: what the check takes the emulated drives for."""
        self.bench, self.device = EmulatedBench(), device
        self.host = stepped_host(self.bench.clock)
        self.check = DeviceCheck(device, self.bench.bus, self.host)

    def do(self, steps: Steps[Result]) -> Result:
        return finish(steps, self)

    def monotonic_ns(self) -> int:
        return self.bench.clock.now_ns

    def wall_ns(self) -> int:
        return self.bench.clock.now_ns

    def sleep_until(self, due_ns: int) -> None:
        while self.bench.clock.now_ns < due_ns:
            self.bench.tick()

    def move_head(self) -> MoveFound:
        self.do(self.check.set_up())
        return self.do(self.check.move_head())


def scaled(ratio: float) -> Device:
    """A device file with another gear ratio than the drives have."""
    axis = DEVICE.insertion
    encoder = axis.encoder._replace(gear_ratio=axis.encoder.gear_ratio * ratio)
    return DEVICE._replace(insertion=axis._replace(encoder=encoder))


def test_nodes_say_who_they_are() -> None:
    checked = Checked()
    found = checked.do(device_check.identify(DEVICE, checked.bench.bus, checked.host))
    assert [one.node for one in found] == list(DEVICE.nodes)
    assert [one.name for one in found] == ["insertion drive", "valve drive", "input module"]
    assert all(one.vendor == checked.bench.take(one.node, 0x1018, 1) for one in found)


def test_a_node_that_is_not_there_is_named() -> None:
    checked = Checked()
    other = DEVICE._replace(valve=DEVICE.valve._replace(node=9))
    with pytest.raises(InputError, match=r"node 9 \(valve drive\) does not answer on interface"):
        checked.do(device_check.identify(other, checked.bench.bus, checked.host))


def test_a_machine_as_its_device_file_says_has_no_problem() -> None:
    checked, told = Checked(), list[str]()
    found = checked.do(
        device_check.check(DEVICE, checked.bench.bus, checked.host, moves=True, tell=told.append)
    )
    (head, valve), vacuum = found.moves, found.vacuum
    assert found.ok
    assert not found.problems
    assert len(told) == 5
    assert head.problem == ""
    assert head.by_drive == pytest.approx(5.0, abs=0.3)
    assert head.by_second_sensor == pytest.approx(5.0, abs=0.5)
    assert abs(checked.bench.shown("readings.head_mm")) < 0.3  # it is back
    assert (valve.problem, valve.by_second_sensor) == ("", None)
    assert valve.by_drive == pytest.approx(0.1, abs=0.02)
    assert vacuum is not None
    assert vacuum.problem == ""
    assert vacuum.reached_mmhg == pytest.approx(50.0, abs=10.0)
    assert vacuum.left_mmhg <= 10.0
    assert not checked.bench.drives.insertion.has_torque


def test_axes_in_torque_mode_are_moved_by_the_drives_own_servos() -> None:
    insertion = DEVICE.insertion._replace(mode=AxisMode.TORQUE)
    checked = Checked(DEVICE._replace(insertion=insertion))
    assert checked.move_head().problem == ""
    assert checked.bench.take(DEVICE.insertion.node, 0x6061) == 8


@pytest.mark.parametrize(("ratio", "factor"), [(2.0, "2"), (0.5, "0.5")])
def test_a_wrong_gear_ratio_shows_in_a_small_move(ratio: float, factor: str) -> None:
    checked = Checked(scaled(ratio))
    found = checked.move_head()
    assert f"wrong by a factor of {factor}" in found.problem
    assert abs(checked.bench.shown("readings.head_mm")) < 15.0


def test_a_head_that_goes_too_far_is_stopped_at_once() -> None:
    checked = Checked(scaled(10.0))
    assert "a scale is wrong" in checked.move_head().problem
    assert abs(checked.bench.shown("readings.head_mm")) < 25.0


def test_a_wrong_sign_shows_in_a_small_move() -> None:
    axis = DEVICE.insertion
    encoder = axis.encoder._replace(reversed=True)
    checked = Checked(DEVICE._replace(insertion=axis._replace(encoder=encoder)))
    assert "wrong sign" in checked.move_head().problem


def test_vacuum_that_does_not_come_is_told() -> None:
    checked = Checked()
    checked.do(checked.check.set_up())
    module = DEVICE.module
    regulator = module.regulator._replace(counts_per_unit=4.0 * module.regulator.counts_per_unit)
    checked.bench.drives.module.module = module._replace(regulator=regulator)
    assert "pump, regulator, leak or scale" in checked.do(checked.check.test_vacuum()).problem
