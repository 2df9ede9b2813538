"""Drive of CiA 402, emulated: power states, cyclic modes, its own stops and its reactions.

It is given what it measures once in a tick, and gives the volts of its motor. It looks at its
control word once in a tick, too: of two that come within one, the first is never seen. The optional
transition 16 (back from quick stop) it does not have.
"""

import math
from collections import deque
from pathlib import Path
from typing import Final, NamedTuple

from canopen.sdo.exceptions import SdoAbortedError

from opensuction.control import servo as servo_step
from opensuction.control.servo import Servo, ServoState
from opensuction.host.host import Clock
from opensuction.kernel.compiled import as_python
from opensuction.machine.canopen import device, power_state
from opensuction.machine.canopen.device import DriveAxis
from opensuction.machine.canopen.objects import AbortConnection, Axis, Mode, NmtState
from opensuction.machine.canopen.power_state import POWERED_UP, PowerState
from opensuction.machine.drives import interpolation, pdo
from opensuction.machine.drives.emulated_node import HOST_LOST, EmulatedNode
from opensuction.machine.drives.interpolation import NO_OFFSET, Bounds, SetPoint
from opensuction.machine.drives.pdo import Key

EDS: Final = Path(__file__).with_name("axis.eds")
DT_S: Final = 0.001
"""Length of a drive's tick."""
FED_TICKS: Final = 16
"""Ticks over which the velocity of the set point is averaged for the feedforward."""
SPEED_TICKS: Final = 10
"""Time constant of the speed that a drive knows of its own encoder."""
ENCODER_LOST, FOLLOWING = 0x7305, 0x8611
"""Error codes of CiA 402: incremental encoder, following error."""
_MOTION, _CURRENT = 0x20, 0x02
"""Bits of the error register."""
_MODES: Final = (Mode.NONE, Mode.HOMING, Mode.CYCLIC_POSITION, Mode.CYCLIC_TORQUE)
_DISABLES, _BRAKES, _STAYS = 0, 2, 6
"""Option codes of quick stop and fault reaction: torque off at once; a ramp, then off; a ramp, and
it stays there."""
_SERVO = as_python(servo_step.step)
_AT_REST: Final = ServoState(0.0, 0.0)


class Motor(NamedTuple):
    """Motor of an axis, as its drive was told."""

    speed_per_v: float
    """Unit/s for each volt."""
    rated_v: float
    """Volts that drive the rated current at standstill."""


class Seen(NamedTuple):
    """Inputs of a drive in a tick."""

    position: float
    """By its encoder, mm or rad."""
    is_valid: bool
    drive_v: float | None
    """Volts that drive current, where the current is measured."""
    inputs: int
    """Digital inputs, as the object 0x60FD holds them."""


class Order(NamedTuple):
    """Outputs of a drive in a tick."""

    position: float
    """Set point."""
    volts: float
    is_on: bool


class EmulatedDrive(EmulatedNode):
    """One axis on the bus."""

    def __init__(self, axis: DriveAxis, servo: Servo, motor: Motor, clock: Clock) -> None:
        self.axis, self._servo, self._motor = axis, servo, motor
        self._scale = axis.counts_per_unit
        self.power = POWERED_UP
        self.withdraws = False
        """A program stored in the machine moves the axis home; only a fault's reset ends it."""
        self.was_reset = False
        """A fault has been reset in this tick."""
        self.stops: tuple[int, int] = (0, 0)
        """Digital inputs that forbid motion towards higher and towards lower counts from the start
        on."""
        self._set_point: SetPoint = interpolation.hold(0.0)
        self._offset = NO_OFFSET
        self._servo_state = _AT_REST
        self._velocities: deque[float] = deque(maxlen=FED_TICKS)
        self._seen = Seen(0.0, is_valid=True, drive_v=None, inputs=0)
        self._speed = self._volts = 0.0
        self._has_target = self._is_homed = self._starts_homing = False
        self._barrier = interpolation.OPEN
        self._stopped = (False, False)
        """Inputs forbid motion to lower and to higher positions, in the axis' unit."""
        self._shift = 0
        super().__init__(axis.node, EDS, clock)

    # What the node tells its profile.

    def on_boot(self) -> None:
        """See `EmulatedNode.on_boot`. A stored program goes on."""
        self.values[Axis.STOP_UP, 0], self.values[Axis.STOP_DOWN, 0] = self.stops
        self.power = POWERED_UP
        self._has_target = self._is_homed = self._starts_homing = False
        self._shift = 0
        if self.withdraws:
            self.power = POWERED_UP._replace(state=PowerState.FAULT)
            self.values[Axis.ERROR_CODE, 0] = HOST_LOST
        self.refresh()

    def on_set_points(self) -> None:
        """See `EmulatedNode.on_set_points`: ignored outside operation, and while it homes."""
        self._has_target = self.power.state == PowerState.OPERATION_ENABLED
        if self._has_target and self._mode != Mode.HOMING:
            counts = self.values[Axis.TARGET_POSITION, 0] - self._shift
            low, high = (self.values[Axis.POSITION_LIMIT, k] for k in (1, 2))
            goal = device.position_of(self.axis, min(max(counts, low), high))
            ticks = self._period_ticks()
            self._set_point = interpolation.aim(self._set_point, goal, ticks)
            per_s = self.values[Axis.VELOCITY_OFFSET, 0] / self._scale
            self._offset = interpolation.aim_offset(self._offset, per_s, ticks)

    def on_written(self, key: Key) -> None:
        """See `EmulatedNode.on_written`: a target counts at once."""
        if key in ((Axis.TARGET_POSITION, 0), (Axis.TARGET_TORQUE, 0)):
            self.on_set_points()

    def on_lost_host(self) -> None:
        """See `EmulatedNode.on_lost_host`: what the object 0x6007 says."""
        reaction = self.values[Axis.ABORT_CONNECTION, 0]
        enabled = self.power.state == PowerState.OPERATION_ENABLED
        if reaction == AbortConnection.WITHDRAW:
            self.withdraw(HOST_LOST)
        elif not enabled:
            return
        elif reaction == AbortConnection.FAULT:
            self.values[Axis.ERROR_CODE, 0] = HOST_LOST
            self.power = power_state.fail_drive(self.power)
        elif reaction == AbortConnection.QUICK_STOP:
            self.power = self.power._replace(state=PowerState.QUICK_STOP_ACTIVE)
        elif reaction == AbortConnection.DISABLE_VOLTAGE:
            self.power = self.power._replace(state=PowerState.SWITCH_ON_DISABLED)

    def withdraw(self, code: int) -> None:
        """Have the program stored in the machine move the axis home. code: of the error."""
        self.withdraws = True
        self.values[Axis.ERROR_CODE, 0] = code
        self.power = self.power._replace(state=PowerState.FAULT)

    def on_host_back(self) -> None:
        """See `EmulatedNode.on_host_back`: a fault stays until it is reset."""
        if self.power.state != PowerState.FAULT:
            self.end_emergency()

    def check_write(self, key: Key, value: int) -> None:
        """See `EmulatedNode.check_write`."""
        if key == (Axis.HOMING_METHOD, 0) and value not in device.HOMES_HERE:
            raise SdoAbortedError(pdo.WRONG_VALUE)
        if key == (Axis.MODE, 0) and value not in _MODES:
            raise SdoAbortedError(pdo.WRONG_VALUE)

    def _period_ticks(self) -> int:
        value, exponent = (self.values[Axis.INTERPOLATION_PERIOD, k] for k in (1, 2))
        return round(value * 10.0**exponent / DT_S)

    # A tick.

    def measure(self, seen: Seen) -> None:
        """Take what it measures, at the end of a tick: the next SYNC is answered with it.

        An encoder that gives no number leaves its count where it was, and a current that is none is
        not measured.
        """
        if not math.isfinite(seen.position):
            seen = seen._replace(position=self._seen.position, is_valid=False)
        if seen.drive_v is not None and not math.isfinite(seen.drive_v):
            seen = seen._replace(drive_v=None)
        moved = (seen.position - self._seen.position) / DT_S
        self._speed += (moved - self._speed) / SPEED_TICKS
        self._seen = seen
        up, down = (seen.inputs & self.values[one, 0] for one in (Axis.STOP_UP, Axis.STOP_DOWN))
        self._stopped = (up != 0, down != 0) if self._scale < 0.0 else (down != 0, up != 0)

    def tick(self) -> Order:
        """The drive a tick on."""
        self._obey()
        self._check()
        self._move()
        return self._drive()

    def fail(self, code: int, bits: int = 0) -> None:
        """See `EmulatedNode.fail`: the reaction to a fault begins."""
        if self.power.state in (PowerState.FAULT, PowerState.FAULT_REACTION_ACTIVE):
            return
        self.values[Axis.ERROR_CODE, 0] = code
        self.power = power_state.fail_drive(self.power)
        self.emergency(code, bits)

    def _obey(self) -> None:
        """Follow the control word, and end what goes on by itself."""
        before = self.power.state
        self.was_reset = False
        if before == PowerState.FAULT_REACTION_ACTIVE and self._has_stopped(Axis.FAULT_REACTION):
            self.power = power_state.end_reaction(self.power)
        if before == PowerState.QUICK_STOP_ACTIVE and self._has_stopped(Axis.QUICK_STOP):
            self.power = self.power._replace(state=PowerState.SWITCH_ON_DISABLED)
        self.power = power_state.step_drive(self.power, self.values[Axis.CONTROL_WORD, 0])
        after = self.power.state
        if before == PowerState.FAULT and after != before:
            self.was_reset, self.withdraws = True, False
            self.values[Axis.ERROR_CODE, 0] = 0
            self.end_emergency()
        if after == PowerState.OPERATION_ENABLED and before != after:
            self._set_point = interpolation.hold(self._seen.position)
            self._servo_state, self._has_target = _AT_REST, False
            self._velocities.clear()
            self._offset = NO_OFFSET
        self._starts_homing = self._starts_homing and after == PowerState.OPERATION_ENABLED
        if self.values[Axis.MODE, 0] in _MODES:
            self.values[Axis.MODE_SHOWN, 0] = self.values[Axis.MODE, 0]

    def _has_stopped(self, option: Axis) -> bool:
        """True once a reaction is over that does not stay."""
        code = self.values[option, 0]
        return code == _DISABLES or (code != _STAYS and self._set_point.velocity == 0.0)

    def _check(self) -> None:
        """Find the drive's own faults."""
        if not self._seen.is_valid:
            self.fail(ENCODER_LOST, _MOTION)
        apart = abs(self._set_point.position - self._seen.position)
        window = self.values[Axis.FOLLOWING_ERROR_WINDOW, 0]
        follows = self.power.state == PowerState.OPERATION_ENABLED and self._mode != (
            Mode.CYCLIC_TORQUE
        )
        if follows and apart * abs(self._scale) > window:
            self.fail(FOLLOWING, _MOTION)

    @property
    def _mode(self) -> int:
        return self.values[Axis.MODE_SHOWN, 0]

    @property
    def has_torque(self) -> bool:
        """True while the power stage drives the motor."""
        state = self.power.state
        if state == PowerState.FAULT_REACTION_ACTIVE:
            return self.values[Axis.FAULT_REACTION, 0] != _DISABLES and self._seen.is_valid
        return state in (PowerState.OPERATION_ENABLED, PowerState.QUICK_STOP_ACTIVE)

    def _move(self) -> None:
        """The set point a tick on."""
        state = self.power.state
        if state == PowerState.OPERATION_ENABLED:
            if self._mode == Mode.HOMING:
                self._home()
            if self._mode == Mode.CYCLIC_TORQUE:
                self._set_point = interpolation.hold(self._seen.position)
            self._set_point = interpolation.follow(self._set_point, self._bounds(), DT_S)
            self._offset = interpolation.follow_offset(self._offset, DT_S)
        elif self.has_torque:
            decelerates = self.values[Axis.QUICK_STOP_DECELERATION, 0]
            per_s2 = decelerates / abs(self._scale)
            self._set_point = interpolation.brake(self._set_point, per_s2, DT_S)
        else:
            self._set_point = interpolation.hold(self._seen.position)

    def _bounds(self) -> Bounds:
        """Bounds of the set point; an input that stops has the position at which it closed."""
        axis, (lower, upper) = self.axis, self._stopped
        self._barrier = interpolation.close(self._barrier, self._seen.position, lower, upper)
        bounds = Bounds(axis.lowest, axis.highest, self._most_per_s())
        return interpolation.within(bounds, self._barrier)

    def _most_per_s(self) -> float:
        encoder = self.axis.encoder
        turns_per_s = self.values[Axis.MAX_SPEED, 0] / 60.0
        return turns_per_s / encoder.gear_ratio * encoder.travel_per_turn

    def _home(self) -> None:
        """Homing where the axis stands: from now on its position is the home offset."""
        starts = bool(self.values[Axis.CONTROL_WORD, 0] & power_state.START_HOMING)
        if starts and not self._starts_homing:
            here = device.wrap(self.values[Axis.HOME_OFFSET, 0] - self._counts())
            self._shift, self._is_homed = here, True
        self._starts_homing = starts

    def _counts(self) -> int:
        """Counts of the encoder before homing."""
        travelled = round(self._seen.position * self._scale)
        return device.wrap(self.axis.zero_counts + travelled)

    def _drive(self) -> Order:
        """Volts of the motor."""
        back_emf_v = self._back_emf_v()
        most_v = self.values[Axis.MAX_TORQUE, 0] / 1000.0 * self._motor.rated_v
        if not self.has_torque:
            self._servo_state, self._volts = _AT_REST, 0.0
            return Order(self._set_point.position, 0.0, is_on=False)
        if self._mode == Mode.CYCLIC_TORQUE:
            volts = self._torque_v() + back_emf_v
        else:
            state, volts = _SERVO(
                self._servo,
                self._servo_state,
                self._position_now(),
                self._fed_velocity(),
                self._seen.position,
                DT_S,
            )
            self._servo_state = state
        limit_v = self._servo.voltage_limit_v
        volts = min(max(volts, back_emf_v - most_v), back_emf_v + most_v)
        self._volts = min(max(volts, -limit_v), limit_v)
        return Order(self._set_point.position, self._volts, is_on=True)

    def _position_now(self) -> float:
        """Set point at the tick's beginning, as what is measured; an input that stops, at once."""
        way = 0.0 if self._barrier != interpolation.OPEN else self._set_point.velocity * DT_S
        return self._set_point.position - way

    def _fed_velocity(self) -> float:
        """Velocity for the feedforward: between two targets it goes over from one to the next.

        Targets are whole counts, and their difference steps: the axis' lead would make jolts of
        that, and the supply cut them off.
        """
        self._velocities.append(self._set_point.velocity)
        if self._takes_offset and self.power.state == PowerState.OPERATION_ENABLED:
            return interpolation.offset_now(self._offset, self._most_per_s(), *self._stopped)
        return sum(self._velocities) / len(self._velocities)

    @property
    def _takes_offset(self) -> bool:
        """True where a frame of set points brings the velocity offset."""
        return any((Axis.VELOCITY_OFFSET, 0) in one.keys for one in self._receives.values())

    def _back_emf_v(self) -> float:
        """Volts that drive no current: by the current where it is measured, as a drive limits that.

        The averaged speed is late, and would take two thirds of the torque while the axis gains it.
        """
        if self._seen.drive_v is not None and self._volts:
            return self._volts - self._seen.drive_v
        return self._speed / self._motor.speed_per_v

    def _torque_v(self) -> float:
        """Volts for the target torque; none while braking, before a target, or into a stop.

        An axis that moves away from a stop is braked.
        """
        braking = self.power.state != PowerState.OPERATION_ENABLED
        if braking or not self._has_target:
            return 0.0
        sign = 1.0 if self._scale > 0.0 else -1.0
        wanted_v = sign * self.values[Axis.TARGET_TORQUE, 0] / 1000.0 * self._motor.rated_v
        lower, upper = self._stopped
        into = (lower and wanted_v < 0.0) or (upper and wanted_v > 0.0)
        if into and self._speed * wanted_v >= 0.0:
            return 0.0
        return wanted_v

    # What the host sees.

    def refresh(self) -> None:
        """See `EmulatedNode.refresh`."""
        status = power_state.write_status(self.power.state, self._flags())
        self.values[Axis.STATUS_WORD, 0] = status
        values, scale = self.values, self._scale
        values[Axis.POSITION, 0] = device.wrap(self._counts() + self._shift)
        values[Axis.VELOCITY, 0] = device.wrap(round(self._speed * scale))
        values[Axis.DIGITAL_INPUTS, 0] = self._seen.inputs
        drive_v = self._seen.drive_v
        if drive_v is None:
            drive_v = self._volts - self._speed / self._motor.speed_per_v if self._volts else 0.0
        sign = 1.0 if scale > 0.0 else -1.0
        ratio = round(1000.0 * sign * drive_v / self._motor.rated_v)
        values[Axis.TORQUE, 0] = min(max(ratio, -0x8000), 0x7FFF)

    def _flags(self) -> int:
        flags = power_state.REMOTE if self.nmt != NmtState.STOPPED else 0
        if self.values[Axis.ERROR_CODE, 0] == FOLLOWING:
            flags |= power_state.FOLLOWING_ERROR
        if any(self._stopped):
            flags |= power_state.INTERNAL_LIMIT
        if self.power.state == PowerState.OPERATION_ENABLED:
            if self._mode == Mode.HOMING:
                flags |= power_state.HOMED if self._is_homed else 0
            elif self._mode != Mode.NONE:
                flags |= power_state.FOLLOWS_TARGET
        return flags
