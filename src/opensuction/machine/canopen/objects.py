"""Objects of the dictionary that controller and drives share, and the frames that carry them.

Each cycle, after the controller's set points, a SYNC makes every node act on them and answer with
its readings. All that passes in a cycle is listed here once, for both ends:

| frame | holds |
|---|---|
| axis, RPDO 1 | control word, target position |
| axis, RPDO 2 | target torque in torque mode, velocity offset in position mode where it is taken |
| axis, TPDO 1 | status word, position, torque |
| axis, TPDO 2 | velocity, digital inputs |
| module, RPDO 1 | digital outputs, analogue outputs |
| module, RPDO 2 | conditions that people shall be told, and the flags beside them |
| module, TPDO 1 | digital inputs |
| module, TPDO 2 | analogue inputs 1 to 4 |
| module, TPDO 3 | analogue inputs 5 to 8 |
"""

import struct
from enum import IntEnum
from typing import Final, NamedTuple

SYNC_ID: Final = 0x80
NMT_ID: Final = 0x000
EMERGENCY_ID: Final = 0x80
HEARTBEAT_ID: Final = 0x700
_RPDO_ID: Final = (0x200, 0x300, 0x400, 0x500)
_TPDO_ID: Final = (0x180, 0x280, 0x380, 0x480)
"""Identifiers of CiA 301's predefined connection set, without the node's number."""


def rpdo_id(node: int, number: int) -> int:
    """Identifier of a set-point frame. number: from 1."""
    return _RPDO_ID[number - 1] + node


def tpdo_id(node: int, number: int) -> int:
    """Identifier of a frame of readings. number: from 1."""
    return _TPDO_ID[number - 1] + node


class Communication(IntEnum):
    """Objects of CiA 301."""

    DEVICE_TYPE = 0x1000
    ERROR_REGISTER = 0x1001
    SYNC_PERIOD_US = 0x1006
    DEVICE_NAME = 0x1008
    HEARTBEAT_CONSUMER = 0x1016
    HEARTBEAT_PRODUCER_MS = 0x1017
    IDENTITY = 0x1018
    ERROR_BEHAVIOUR = 0x1029
    RPDO = 0x1400
    RPDO_MAP = 0x1600
    TPDO = 0x1800
    TPDO_MAP = 0x1A00


class Axis(IntEnum):
    """Objects of CiA 402, and two of the manufacturer's."""

    STOP_UP = 0x2300
    """Mask of digital inputs that forbid motion towards higher counts, whether a host lives."""
    STOP_DOWN = 0x2301
    """Likewise towards lower counts."""
    ABORT_CONNECTION = 0x6007
    ERROR_CODE = 0x603F
    CONTROL_WORD = 0x6040
    STATUS_WORD = 0x6041
    QUICK_STOP = 0x605A
    FAULT_REACTION = 0x605E
    MODE = 0x6060
    MODE_SHOWN = 0x6061
    POSITION = 0x6064
    FOLLOWING_ERROR_WINDOW = 0x6065
    VELOCITY = 0x606C
    """In counts/s: readings are carried on by it, over a period or two."""
    TARGET_TORQUE = 0x6071
    VELOCITY_OFFSET = 0x60B1
    MAX_TORQUE = 0x6072
    RATED_CURRENT_MA = 0x6075
    RATED_TORQUE_MNM = 0x6076
    TORQUE = 0x6077
    TARGET_POSITION = 0x607A
    HOME_OFFSET = 0x607C
    POSITION_LIMIT = 0x607D
    MAX_SPEED = 0x6080
    """Of the motor, turns each minute."""
    QUICK_STOP_DECELERATION = 0x6085
    """In counts/s2."""
    HOMING_METHOD = 0x6098
    HOMING_SPEEDS = 0x6099
    """Towards a switch, and at it; in counts/s."""
    HOMING_ACCELERATION = 0x609A
    """In counts/s2."""
    INTERPOLATION_PERIOD = 0x60C2
    DIGITAL_INPUTS = 0x60FD
    SUPPORTED_MODES = 0x6502


class Module(IntEnum):
    """Objects of CiA 401, and one of the manufacturer's."""

    DIGITAL_INPUTS = 0x6000
    DIGITAL_OUTPUTS = 0x6200
    OUTPUT_ERROR_MODE = 0x6206
    OUTPUT_ERROR_VALUE = 0x6207
    ANALOGUE_INPUT = 0x6401
    """`NO_VALUE` where a sensor tells nothing."""
    ANALOGUE_OUTPUT = 0x6411
    ANALOGUE_ERROR_MODE = 0x6443
    ANALOGUE_ERROR_VALUE = 0x6444
    ANNUNCIATOR = 0x2100
    """Conditions shown at the bedside, and the flags of `AnnunciatorFlag`."""


NO_VALUE: Final = -0x8000
"""Counts of an analogue input whose sensor tells nothing: its line is open."""


class NmtState(IntEnum):
    """State of a node on the network, as its heartbeat tells it."""

    BOOTING = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


class NmtCommand(IntEnum):
    """Command to a node, or to all."""

    START = 1
    STOP = 2
    PREPARE = 128
    RESET = 129
    RESET_COMMUNICATION = 130


class Mode(IntEnum):
    """Mode of operation of an axis."""

    NONE = 0
    HOMING = 6
    CYCLIC_POSITION = 8
    CYCLIC_TORQUE = 10


class AbortConnection(IntEnum):
    """Reaction of an axis to a host that is lost (object 0x6007)."""

    WITHDRAW = -1
    """The manufacturer's own: a program stored in the drive moves the axis home."""
    NOTHING = 0
    """Never configured here: the motor would run on after the host has died."""
    FAULT = 1
    DISABLE_VOLTAGE = 2
    QUICK_STOP = 3


class AnnunciatorFlag(IntEnum):
    """Bits beside the conditions in the annunciator's frame."""

    RESET = 1
    RELEASED = 2


class Frame(NamedTuple):
    """Layout of a frame: objects in their order, and how they are packed."""

    objects: tuple[tuple[int, int, int], ...]
    """Index, subindex and length in bits of each: what a PDO mapping entry holds."""
    layout: struct.Struct

    def pack(self, *values: int) -> bytes:
        """Bytes of the frame. Raises struct.error for a value that does not fit."""
        return self.layout.pack(*values)

    def unpack(self, data: bytes) -> tuple[int, ...]:
        """Values of the frame. Raises struct.error for another length."""
        return self.layout.unpack(data)

    @property
    def entries(self) -> tuple[int, ...]:
        """Mapping entries, as the objects 0x1600 and 0x1A00 hold them."""
        return tuple(index << 16 | sub << 8 | bits for index, sub, bits in self.objects)


def _frame(layout: str, *objects: tuple[int, int, int]) -> Frame:
    return Frame(objects, struct.Struct(f"<{layout}"))


AXIS_TARGET: Final = _frame("Hi", (Axis.CONTROL_WORD, 0, 16), (Axis.TARGET_POSITION, 0, 32))
AXIS_TORQUE: Final = _frame("h", (Axis.TARGET_TORQUE, 0, 16))
AXIS_FEEDFORWARD: Final = _frame("i", (Axis.VELOCITY_OFFSET, 0, 32))
AXIS_STATUS: Final = _frame(
    "Hih", (Axis.STATUS_WORD, 0, 16), (Axis.POSITION, 0, 32), (Axis.TORQUE, 0, 16)
)
AXIS_MOTION: Final = _frame("iI", (Axis.VELOCITY, 0, 32), (Axis.DIGITAL_INPUTS, 0, 32))
MODULE_OUTPUTS: Final = _frame(
    "Bhh",
    (Module.DIGITAL_OUTPUTS, 1, 8),
    (Module.ANALOGUE_OUTPUT, 1, 16),
    (Module.ANALOGUE_OUTPUT, 2, 16),
)
MODULE_ANNUNCIATOR: Final = _frame("Q", (Module.ANNUNCIATOR, 1, 64))
MODULE_DIGITAL: Final = _frame("BB", (Module.DIGITAL_INPUTS, 1, 8), (Module.DIGITAL_INPUTS, 2, 8))
MODULE_ANALOGUE: Final = tuple(
    _frame("hhhh", *((Module.ANALOGUE_INPUT, first + k, 16) for k in range(4))) for first in (1, 5)
)

CONDITION_BITS: Final = 56
"""Bits of the annunciator's object that hold conditions; its flags are above them."""
FLAG_SHIFT: Final = 56
