"""Homing of a machine's drives: where each of them stands, by the method of the device file.

A drive with an incremental encoder does not know its position when it is switched on. A method of
CiA 402 finds it: by a switch, an end or an index, or by being told that the axis stands at home
now. A person watches: the head may move over its whole range. Afterwards the head's second sensor
has to agree.
"""

from collections.abc import Callable
from typing import Final

from opensuction.host.host import NS_PER_S, Steps
from opensuction.kernel.errors import InputError
from opensuction.machine.canopen import node_setup, process_image
from opensuction.machine.canopen.device import Device, position_of
from opensuction.machine.canopen.power_state import HOMED, HOMING_ERROR, PowerState
from opensuction.machine.canopen.process_image import INSERTION, VALVE
from opensuction.machine.canopen.supervised_machine import SupervisedMachine
from opensuction.result.device_check_result import HomedFound

NAMES_UNITS: Final = {INSERTION: ("insertion", "mm"), VALVE: ("valve", "rad")}
COMMANDS: Final = {INSERTION: "insertion_on", VALVE: "valve_on"}
ENDS_S: Final = 10.0
"""[design] Longest homing of an axis that stands still; one that moves has the time for its range
at the lower speed besides."""
BELIEVED_S: Final = 0.2
"""[design] What a drive says of its homing before is over by then."""
NEAR: Final = {INSERTION: 1.0, VALVE: 0.05}
"""[design] Distance from its home at which an axis may stand afterwards, mm and rad."""
UNSEEN: Final = "the head's second sensor tells nothing: nobody knows how far it moves"
AGREES_MM: Final = 2.0
"""[design] Difference of the head's two sensors that is mounting and backlash."""


def places_of(device: Device) -> tuple[int, ...]:
    """Drives that are homed, in the order in which they are."""
    axes = enumerate(device.axes)
    return tuple(place for place, axis in axes if axis.homing.method != 0)


def require(device: Device) -> None:
    """Raises InputError for a device of which no drive is homed."""
    if not places_of(device):
        raise InputError(
            f"'{device.name}': insertion.homing.method and valve.homing.method are 0, so its "
            "drives know where they are; give the method of one that does not"
        )


def announce(device: Device) -> str:
    """Words for a person before drives are homed."""
    told = ""
    for place in places_of(device):
        homing, name = device.axes[place].homing, process_image.NAMES[place]
        told += (
            f"The {name} will find its home by method {homing.method}, and may move over its whole "
            "range. "
            if homing.moves
            else f"The {name} will take itself to be at {homing.at:g} {NAMES_UNITS[place][1]}: it "
            "has to stand there now. "
        )
    return told


def home_axes(
    machine: SupervisedMachine, tell: Callable[[str], None]
) -> Steps[tuple[HomedFound, ...]]:
    """Home each drive that is; a machine that is set up. tell: of what is done.

    The valve waits for a head that knows where it is.
    """
    found: list[HomedFound] = []
    for place in places_of(machine.device):
        tell(f"Homing the {process_image.NAMES[place]}")
        found.append((yield from _home(machine, place)))
        if found[-1].problem:
            break
    return tuple(found)


def _home(machine: SupervisedMachine, place: int) -> Steps[HomedFound]:
    """Home a drive, and look where it takes itself to be."""
    axis = machine.device.axes[place]
    before = _position(machine, place)
    problem = yield from _ask(machine, place, node_setup.start_homing(machine.device, place))
    if not problem:
        machine.port.homing.add(place)
        problem = yield from _wait(machine, place)
        machine.port.homing.discard(place)
    yield from machine.release()
    refused = yield from _ask(machine, place, node_setup.end_homing(machine.device, place))
    problem = problem or refused
    second = machine.readings.carriage_mm
    knows = place == INSERTION and machine.readings.carriage_valid
    return HomedFound(
        axis=NAMES_UNITS[place][0],
        unit=NAMES_UNITS[place][1],
        method=axis.homing.method,
        at=axis.homing.at,
        before=before,
        by_drive=_position(machine, place),
        by_second_sensor=second if knows else None,
        problem=problem or _judge(machine, place, second if knows else None),
    )


def _ask(machine: SupervisedMachine, place: int, steps: node_setup.Setup) -> Steps[str]:
    """Requests to a drive, to their end; differences in words."""
    machine.port.ask(place, steps)
    while machine.port.is_asking(place):
        yield from machine.drive(machine.device.bus.period_s)
    return machine.port.refusal(place)


def _wait(machine: SupervisedMachine, place: int) -> Steps[str]:
    """Torque on, until the drive has found its home; the problem in words, "" for none."""
    axis, clock, started_ns = machine.device.axes[place], machine.host.clock, 0
    span = axis.highest - axis.lowest
    ends_s = ENDS_S + (span / axis.homing.slow_per_s if axis.homing.moves else 0.0)
    problem = f"its home was not found within {ends_s:.0f} s"
    first_mm = machine.readings.carriage_mm
    is_watched = place == INSERTION and axis.homing.moves
    if is_watched and not machine.readings.carriage_valid:
        return UNSEEN

    def is_over() -> bool:
        nonlocal started_ns, problem
        image, objection = machine.port.image, machine.port.objection(place)
        if objection:
            problem = f"its drive {objection}"
            return True
        if process_image.state_of(image, place) != PowerState.OPERATION_ENABLED:
            return False
        started_ns = started_ns or clock.monotonic_ns()
        moved_mm = abs(machine.readings.carriage_mm - first_mm)
        if is_watched and not machine.readings.carriage_valid:
            problem = UNSEEN
            return True
        if is_watched and moved_mm > span:
            problem = f"the head was stopped after {moved_mm:.0f} mm, which is more than its range"
            return True
        if clock.monotonic_ns() - started_ns < BELIEVED_S * NS_PER_S:
            return False
        status = image.axes[place].status
        if status & HOMING_ERROR:
            problem = f"its drive says that homing has failed (status word {status:#06x})"
        elif status & HOMED == HOMED:
            problem = ""
        else:
            return False
        return True

    yield from machine.drive(ends_s, lambda _: {COMMANDS[place]: True}, is_over)
    return problem


def _judge(machine: SupervisedMachine, place: int, second_mm: float | None) -> str:
    """Problem of a drive that says that it was homed, in words; "" for none."""
    (name, unit), axis = NAMES_UNITS[place], machine.device.axes[place]
    here = _position(machine, place)
    if abs(here - axis.homing.at) > NEAR[place]:
        return (
            f"it takes itself to be at {here:.2f} {unit} and should be at {axis.homing.at:g} "
            f"({name}.homing.at); a drive may count the home offset (0x607C) the other way"
        )
    if second_mm is not None and abs(second_mm - here) > AGREES_MM:
        return (
            f"it is at {here:.2f} mm and the head's second sensor at {second_mm:.2f}: it did not "
            f"stand at its home, or {name}.homing.at or module.carriage is wrong"
        )
    return ""


def _position(machine: SupervisedMachine, place: int) -> float:
    """Position by the drive, wherever it takes itself to be."""
    return position_of(machine.device.axes[place], machine.port.image.axes[place].counts)
