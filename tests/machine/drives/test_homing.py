"""Homing before emulated drives: whatever a drive takes itself to be at, and what goes wrong."""

from functools import partial

import pytest

from opensuction.host.host import Steps
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import device_check, homing
from opensuction.machine.canopen.device import Device, DriveAxis
from opensuction.machine.canopen.objects import Axis
from opensuction.machine.drives import emulated_drive, interpolation
from opensuction.machine.drives.emulated_drive import EmulatedDrive
from opensuction.machine.drives.node_fault import NodeFault, Request
from opensuction.machine.drives.pdo import Key
from opensuction.result.device_check_result import DeviceCheckResult, HomedFound
from tests.machine.drives.emulated_bench import DEVICE, INSERTION, VALVE
from tests.machine.drives.test_device_check import Checked

SWITCH_MM = -6.0
"""Where a drive of these tests finds its home, which moves there."""


def homed(axis: DriveAxis, method: int, at: float = 0.0) -> DriveAxis:
    return axis._replace(homing=axis.homing._replace(method=method, at=at))


def device(method: int = 37, at: float = 0.0, valve: int = 0) -> Device:
    """A device file by which drives are homed."""
    return DEVICE._replace(
        insertion=homed(DEVICE.insertion, method, at), valve=homed(DEVICE.valve, valve)
    )


def home(checked: Checked, *, moves: bool = False) -> Steps[DeviceCheckResult]:
    return device_check.check(
        checked.device,
        checked.bench.bus,
        checked.host,
        homes=True,
        moves=moves,
        tell=lambda _: None,
    )


def strayed(checked: Checked, mm: float, node: int = INSERTION) -> None:
    """The drive was switched on, and takes itself to be elsewhere."""
    drive = next(one for one in checked.bench.drives.nodes if one.number == node)
    assert isinstance(drive, EmulatedDrive)
    drive._shift = round(mm * DEVICE.insertion.counts_per_unit)


def head(found: DeviceCheckResult) -> HomedFound:
    return found.homed[0]


@pytest.mark.parametrize("off_mm", [-300.0, 0.0, 31.7, 5000.0])
@pytest.mark.parametrize("method", [35, 37])
def test_a_drive_knows_where_it_stands_whatever_it_took_itself_for(
    method: int, off_mm: float
) -> None:
    checked = Checked(device(method, valve=method))
    strayed(checked, off_mm)
    found = checked.do(home(checked))
    assert found.ok, found.problems
    assert [one.axis for one in found.homed] == ["insertion", "valve"]
    assert head(found).before == pytest.approx(off_mm, abs=0.1)
    assert head(found).by_drive == pytest.approx(0.0, abs=0.1)
    assert head(found).by_second_sensor == pytest.approx(0.0, abs=0.5)
    assert found.inputs.head_mm == pytest.approx(0.0, abs=0.1)
    assert abs(checked.bench.shown("readings.head_mm")) < 0.1  # nothing has moved
    assert not checked.bench.drives.insertion.has_torque
    assert checked.bench.take(INSERTION, Axis.MODE_SHOWN) == 8


def test_it_may_be_done_again() -> None:
    for off_mm in (25.0, -40.0):
        checked = Checked(device())
        strayed(checked, off_mm)
        assert checked.do(home(checked)).ok
        strayed(checked, 2.0 * off_mm)  # without having been switched off
        again = checked.do(home(checked))
        assert head(again).before == pytest.approx(2.0 * off_mm, abs=0.1)
        assert again.ok


def test_a_head_that_does_not_stand_at_its_home_is_told_by_the_second_sensor() -> None:
    checked = Checked(device(at=30.0, valve=37))
    found = checked.do(home(checked))
    assert "30.00 mm and the head's second sensor at" in head(found).problem
    assert not found.ok
    assert len(found.homed) == 1  # the valve waits for a head that knows where it is


def test_nothing_is_checked_by_moves_after_a_homing_that_failed() -> None:
    checked = Checked(device(at=30.0))
    assert checked.do(home(checked, moves=True)).moves == ()
    assert abs(checked.bench.shown("readings.head_mm")) < 0.1


def test_a_method_that_a_drive_does_not_have_is_told_and_nothing_moves() -> None:
    checked = Checked(device(method=17))
    found = checked.do(home(checked))
    assert head(found).problem == (
        "node 1 (insertion drive): object 0x6098:00 does not take this value"
    )
    assert abs(checked.bench.shown("readings.head_mm")) < 0.1
    assert checked.bench.take(INSERTION, Axis.MODE_SHOWN) == 8


@pytest.mark.parametrize(
    ("status", "says"),
    [(0, "its home was not found within 10 s"), (1 << 13, "says that homing has failed")],
)
def test_a_drive_that_does_not_find_its_home_is_told(
    monkeypatch: pytest.MonkeyPatch, status: int, says: str
) -> None:
    monkeypatch.setattr(EmulatedDrive, "_home", lambda _: None)
    checked = Checked(device())
    flags = EmulatedDrive._flags
    monkeypatch.setattr(EmulatedDrive, "_flags", lambda one: flags(one) | status)
    assert says in head(checked.do(home(checked))).problem
    assert not checked.bench.drives.insertion.has_torque


def test_a_drive_that_is_lost_meanwhile_is_told() -> None:
    checked = Checked(device())
    steps = home(checked)
    for due_ns in steps:
        checked.sleep_until(due_ns)
        if checked.bench.drives.insertion.has_torque:
            checked.bench.drives.break_down(Request(NodeFault.BUS_OFF, INSERTION, 0.0))
            break
    assert "its drive" in head(checked.do(steps)).problem


def moves_home(one: EmulatedDrive) -> None:
    """Homing by a switch, of a drive that has such a method: inwards is away from it."""
    starts = bool(one.values[Axis.CONTROL_WORD, 0] & 0x10)
    here = one._seen.position
    if starts and here > SWITCH_MM and not one._is_homed:
        per_s = one.values[Axis.HOMING_SPEEDS, 1] / abs(one._scale)
        goal = one._set_point.position - per_s * emulated_drive.DT_S
        one._set_point = interpolation.aim(one._set_point, goal, 1)
    elif starts and not one._is_homed:
        one._shift = one.values[Axis.HOME_OFFSET, 0] - one._counts()
        one._set_point, one._is_homed = interpolation.hold(here), True


def take_any(one: EmulatedDrive, key: Key, value: int) -> None:
    """Values of a drive that has every method."""


@pytest.mark.parametrize("off_mm", [-300.0, 31.7])
def test_a_drive_that_moves_to_its_home_is_followed_there(
    monkeypatch: pytest.MonkeyPatch, off_mm: float
) -> None:
    monkeypatch.setattr(EmulatedDrive, "_home", moves_home)
    monkeypatch.setattr(EmulatedDrive, "check_write", take_any)
    checked = Checked(device(method=17, at=SWITCH_MM))
    drive = checked.bench.drives.insertion
    strayed(checked, off_mm)
    found = checked.do(home(checked))
    assert found.ok, found.problems
    assert checked.bench.shown("readings.head_mm") == pytest.approx(SWITCH_MM, abs=1.0)
    assert head(found).by_second_sensor == pytest.approx(SWITCH_MM, abs=1.5)
    counts = DEVICE.insertion.counts_per_unit
    assert drive.values[Axis.HOMING_SPEEDS, 1] == round(20.0 * counts)
    assert drive.values[Axis.HOMING_SPEEDS, 2] == round(5.0 * counts)
    assert drive.values[Axis.HOMING_ACCELERATION, 0] == round(200.0 * counts)


def test_a_head_that_goes_further_than_its_range_is_stopped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(EmulatedDrive, "_home", moves_home)
    monkeypatch.setattr(EmulatedDrive, "check_write", take_any)
    short = DEVICE.insertion._replace(lowest=-5.0, highest=0.0)
    checked = Checked(DEVICE._replace(insertion=homed(short, 17)))
    assert "which is more than its range" in head(checked.do(home(checked))).problem
    assert checked.bench.shown("readings.head_mm") > -8.0


def test_a_head_whose_second_sensor_tells_nothing_is_not_moved_to_its_home(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(EmulatedDrive, "_home", moves_home)
    monkeypatch.setattr(EmulatedDrive, "check_write", take_any)
    made = device(method=17, at=SWITCH_MM)
    lacking = made.module.carriage._replace(channel=0)
    checked = Checked(made._replace(module=made.module._replace(carriage=lacking)))
    assert "nobody knows how far it moves" in head(checked.do(home(checked))).problem
    assert abs(checked.bench.shown("readings.head_mm")) < 0.1


def test_of_a_device_without_a_method_nothing_is_homed() -> None:
    with pytest.raises(InputError, match="its drives know where they are"):
        homing.require(DEVICE)
    homing.require(device(0, valve=37))


def test_a_person_is_told_what_will_move_and_what_has_to_stand_at_home() -> None:
    told = homing.announce(device(method=17, valve=37))
    assert "insertion drive will find its home by method 17, and may move over its whole" in told
    assert "valve drive will take itself to be at 0 rad: it has to stand there now" in told
    assert homing.announce(device(0)) == ""


def test_a_valve_alone_is_homed() -> None:
    checked = Checked(device(0, valve=35))
    strayed(checked, 1.0, VALVE)
    (found,) = checked.do(home(checked)).homed
    assert (found.axis, found.unit, found.problem) == ("valve", "rad", "")
    assert found.by_drive == pytest.approx(0.0, abs=0.01)
    assert found.by_second_sensor is None


def test_wrong_offsets_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A drive that counts the home offset the other way."""
    checked = Checked(device(at=-30.0))
    drive = checked.bench.drives.insertion

    def other_way(one: EmulatedDrive) -> None:
        if one.values[Axis.CONTROL_WORD, 0] & 0x10 and not one._is_homed:
            one._shift, one._is_homed = -one.values[Axis.HOME_OFFSET, 0] - one._counts(), True

    monkeypatch.setattr(drive, "_home", partial(other_way, drive))
    assert "count the home offset (0x607C) the other way" in head(checked.do(home(checked))).problem
