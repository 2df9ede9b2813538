"""Check of a machine on a bus: its nodes, inputs and homing, a small move of each axis, vacuum.

A device file may be wrong in what no node can tell: a gear ratio, a sign, the scale of a sensor. A
small move at half of the torque shows it: the head by its second sensor, which sits behind gear
and rack. It is stopped at once where that sensor says that it goes too far. Whoever asks for a move
watches it, with a hand at the emergency stop and no catheter in anybody.

Steps, as of any process (`host.host.Steps`): the caller sleeps until the next one.
"""

from collections.abc import Callable, Generator
from typing import Any, Final, TypeVar

from opensuction.host.host import Host, Steps, after
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Readings
from opensuction.machine.canopen import homing, node_setup
from opensuction.machine.canopen.device import Device
from opensuction.machine.canopen.frame_bus import CanFrame, FrameBus
from opensuction.machine.canopen.process_image import NAMES
from opensuction.machine.canopen.supervised_machine import SupervisedMachine
from opensuction.result.device_check_result import (
    DeviceCheckResult,
    InputsFound,
    MoveFound,
    NodeFound,
    VacuumFound,
)

TAKE_UP_MM, MOVE_MM, MOVE_MM_PER_S = 1.0, 5.0, 5.0
"""First the gear's backlash is taken up, then the head is moved by this much."""
MOVE_RAD, MOVE_RAD_PER_S = 0.1, 0.2
SETTLES_S: Final = 1.0
ENABLES_S: Final = 0.5
RIGHT: Final = 0.2
"""Largest deviation, as a share: backlash and noise are a tenth of `MOVE_MM`, a wrong gear more."""
TOO_FAR: Final = 2.0
"""Times the move at which it is stopped."""
VACUUM_MMHG, VACUUM_S, VENTS_S = 50.0, 10.0, 5.0

Result = TypeVar("Result")


def check(
    device: Device,
    bus: FrameBus,
    host: Host,
    *,
    homes: bool = False,
    moves: bool,
    tell: Callable[[str], None],
) -> Steps[DeviceCheckResult]:
    """Check a machine. tell: told of what is done.

    homes: drives are homed before. moves: axes are moved and a vacuum is drawn, too; not where
    homing has failed. Raises InputError where a node does not answer, or is not as the device file
    says.
    """
    tell("Asking the nodes who they are")
    nodes = yield from identify(device, bus, host)
    tell("Setting them up and reading their inputs")
    checked = DeviceCheck(device, bus, host)
    yield from checked.set_up()
    homed = (yield from homing.home_axes(checked, tell)) if homes else ()
    inputs = _list_inputs(checked.readings)
    found: list[MoveFound] = []
    vacuum, problems = None, [f"{one.axis}: {one.problem}" for one in homed if one.problem]
    moves = moves and not problems
    problems += _missing(inputs)
    if moves:
        tell(f"Moving the head by {TAKE_UP_MM + MOVE_MM:g} mm inwards and back")
        found.append((yield from checked.move_head()))
        tell(f"Moving the valve by {MOVE_RAD:g} rad; its spring closes it")
        found.append((yield from checked.move_valve()))
        tell(f"Drawing {VACUUM_MMHG:g} mmHg, and venting")
        vacuum = yield from checked.test_vacuum()
        problems += [f"{one.axis}: {one.problem}" for one in found if one.problem]
        problems += [f"vacuum: {vacuum.problem}"] if vacuum.problem else []
    return DeviceCheckResult(
        ok=not problems,
        device=device.name,
        in_silico=device.in_silico,
        interface=device.bus.interface,
        channel=device.bus.channel,
        nodes=nodes,
        homed=homed,
        inputs=inputs,
        moves=tuple(found),
        vacuum=vacuum,
        problems=tuple(problems),
    )


def _list_inputs(found: Readings) -> InputsFound:
    """Readings, without those that are not valid."""
    monitor = found.monitor
    return InputsFound(
        head_mm=found.head_mm if found.head_valid else None,
        carriage_mm=found.carriage_mm if found.carriage_valid else None,
        cam_rad=found.cam_rad if found.cam_valid else None,
        line_vacuum_mmhg=found.line_vacuum_mmhg if found.vacuum_valid else None,
        contact_closed=found.contact_closed if found.contact_valid else None,
        mouth_clear=found.mouth_clear,
        monitor_connected=monitor.connected,
        spo2_percent=monitor.spo2_percent if monitor.spo2_valid else None,
        heart_rate_per_min=monitor.heart_rate_per_min if monitor.heart_rate_valid else None,
        airway_pressure_cmh2o=(
            monitor.airway_pressure_cmh2o if monitor.airway_pressure_valid else None
        ),
    )


def _missing(inputs: InputsFound) -> list[str]:
    """Inputs that no machine does without, and that tell nothing."""
    names = {
        "head_mm": "the insertion drive tells no position",
        "carriage_mm": "the head's second sensor tells nothing",
        "cam_rad": "the valve drive tells no position",
        "line_vacuum_mmhg": "the vacuum sensor tells nothing",
        "contact_closed": "the line of the contact switch is open",
    }
    return [words for name, words in names.items() if getattr(inputs, name) is None]


def identify(device: Device, bus: FrameBus, host: Host) -> Steps[tuple[NodeFound, ...]]:
    """Identity of each node. Raises InputError for one that does not answer."""
    found = []
    for place, node in enumerate(device.nodes):
        asked = node_setup.read_identity(device, place)
        values = yield from _ask(asked, bus, host)
        if not values:
            raise InputError(
                f"node {node} ({NAMES[place]}) does not answer on interface "
                f"'{device.bus.interface}', channel '{device.bus.channel}'"
            )
        found.append(NodeFound(NAMES[place], node, *values))
    return tuple(found)


def _ask(
    asked: Generator[CanFrame, bytes | None, Result], bus: FrameBus, host: Host
) -> Steps[Result]:
    """Answer to requests by SDO."""
    request = next(asked)
    while True:
        bus.send([request])
        ends_ns, answer = after(host.clock, node_setup.PATIENCE_S), None
        while answer is None and host.clock.monotonic_ns() < ends_ns:
            yield after(host.clock, 0.001)
            for frame in bus.receive():
                if node_setup.is_answer(request, frame):
                    answer = frame.data
        try:
            request = asked.send(answer)
        except StopIteration as end:
            result: Result = end.value
            return result


class DeviceCheck(SupervisedMachine):
    """Moves and tests of a machine, one after the other."""

    def move_head(self) -> Steps[MoveFound]:
        """Move the catheter head inwards and back, and compare its two sensors."""
        first, begun = self.readings.head_mm, self.readings
        yield from self.drive(ENABLES_S, lambda _: {"insertion_on": True, "head_mm": first})
        whole = yield from self._move_head_to(first + TAKE_UP_MM, begun)
        if whole:
            begun = self.readings
            whole = yield from self._move_head_to(first + TAKE_UP_MM + MOVE_MM, begun)
        ended = self.readings
        if whole:
            yield from self._move_head_to(first, ended)
        yield from self.release()
        second = ended.carriage_mm - begun.carriage_mm
        knows = begun.carriage_valid and ended.carriage_valid
        return _judge_head(ended.head_mm - begun.head_mm, second if knows else None, ended)

    def _move_head_to(self, to_mm: float, begun: Readings) -> Steps[bool]:
        """Move the head; false where it went too far from where it began, and was stopped."""
        far_mm = TOO_FAR * MOVE_MM

        def goes_too_far() -> bool:
            now = self.readings
            moved = (now.head_mm - begun.head_mm, now.carriage_mm - begun.carriage_mm)
            return not now.head_valid or any(abs(one) > far_mm for one in moved)

        from_mm = self.readings.head_mm
        lasts_s = abs(to_mm - from_mm) / MOVE_MM_PER_S

        def command(at_s: float) -> dict[str, Any]:
            share = min(at_s / lasts_s, 1.0) if lasts_s else 1.0
            return {"insertion_on": True, "head_mm": from_mm + share * (to_mm - from_mm)}

        return (yield from self.drive(lasts_s + SETTLES_S, command, goes_too_far))

    def move_valve(self) -> Steps[MoveFound]:
        """Move the cam towards open, and let its spring close it. No second sensor tells."""
        first = self.readings.cam_rad
        yield from self.drive(ENABLES_S, lambda _: {"valve_on": True, "cam_rad": first})

        def command(at_s: float) -> dict[str, Any]:
            return {"valve_on": True, "cam_rad": first + min(at_s * MOVE_RAD_PER_S, MOVE_RAD)}

        def goes_too_far() -> bool:
            now = self.readings
            return not now.cam_valid or abs(now.cam_rad - first) > TOO_FAR * MOVE_RAD

        yield from self.drive(MOVE_RAD / MOVE_RAD_PER_S + SETTLES_S, command, goes_too_far)
        ended = self.readings
        yield from self.release()
        moved, problem = ended.cam_rad - first, ""
        if not ended.cam_valid:
            problem = "its drive was lost meanwhile"
        elif abs(moved - MOVE_RAD) > RIGHT * MOVE_RAD:
            problem = f"it moved by {moved:.3f} rad, and was told to by {MOVE_RAD:g}"
        return MoveFound("valve", "rad", MOVE_RAD, moved, None, problem)

    def test_vacuum(self) -> Steps[VacuumFound]:
        """Draw a vacuum behind the closed valve, then vent the line."""

        def has_come() -> bool:
            return self.readings.line_vacuum_mmhg >= (1.0 - RIGHT) * VACUUM_MMHG

        def has_gone() -> bool:
            return self.readings.line_vacuum_mmhg <= RIGHT * VACUUM_MMHG

        def pump(_: float) -> dict[str, Any]:
            return {"pump_on": True, "vacuum_mmhg": VACUUM_MMHG}

        begun = self.readings.line_vacuum_mmhg
        yield from self.drive(VACUUM_S, pump, has_come)
        yield from self.drive(SETTLES_S, pump)
        reached = self.readings.line_vacuum_mmhg
        yield from self.drive(VENTS_S, stops=has_gone)
        left, problem = self.readings.line_vacuum_mmhg, ""
        if not self.readings.vacuum_valid:
            problem = "its sensor was lost meanwhile"
        elif begun > RIGHT * VACUUM_MMHG:
            problem = f"there were {begun:.0f} mmHg before the pump ran"
        elif abs(reached - VACUUM_MMHG) > RIGHT * VACUUM_MMHG:
            problem = f"{reached:.0f} mmHg came of {VACUUM_MMHG:g}: pump, regulator, leak or scale"
        elif left > RIGHT * VACUUM_MMHG:
            problem = f"{left:.0f} mmHg were left {VENTS_S:g} s after the line was vented"
        return VacuumFound(VACUUM_MMHG, reached, left, problem)


def _judge_head(drive_mm: float, second_mm: float | None, ended: Readings) -> MoveFound:
    """Compare the two sensors of the head after a move."""
    if not ended.head_valid:
        problem = "its drive was lost meanwhile"
    elif second_mm is None:
        problem = "the head's second sensor tells nothing: nobody knows how far it moved"
    elif abs(second_mm) < RIGHT * abs(drive_mm):
        problem = (
            f"the drive counted {drive_mm:.2f} mm and the head's second sensor {second_mm:.2f}: "
            "it slips, a scale is wrong, or that sensor is another one"
        )
    elif second_mm * drive_mm < 0.0:
        problem = (
            f"the drive counted {drive_mm:.2f} mm and the head's second sensor {second_mm:.2f}: "
            "one of them has the wrong sign (insertion.encoder.reversed, module.carriage)"
        )
    elif abs(second_mm - drive_mm) > RIGHT * abs(drive_mm):
        problem = (
            f"the drive counted {drive_mm:.2f} mm and the head's second sensor {second_mm:.2f}: "
            f"a scale is wrong by a factor of {second_mm / drive_mm:.2g} (insertion.encoder, "
            "module.carriage)"
        )
    elif abs(drive_mm - MOVE_MM) > RIGHT * MOVE_MM:
        problem = f"it moved by {drive_mm:.2f} mm, and was told to by {MOVE_MM:g}"
    else:
        problem = ""
    return MoveFound("insertion", "mm", MOVE_MM, drive_mm, second_mm, problem)
