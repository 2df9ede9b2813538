"""Result of the check of a machine on a bus: its nodes, inputs, homing, small moves and vacuum.

Names and units of the fields are those of the JSON object of ``opensuction device``.
"""

from typing import NamedTuple


class NodeFound(NamedTuple):
    """Node on the bus, as it says itself (object 0x1018)."""

    name: str
    node: int
    vendor: int
    product: int
    revision: int


class InputsFound(NamedTuple):
    """Inputs at rest; None where an input is not valid, or the machine does not have it."""

    head_mm: float | None
    carriage_mm: float | None
    """By the second sensor of the head."""
    cam_rad: float | None
    line_vacuum_mmhg: float | None
    contact_closed: bool | None
    mouth_clear: bool
    """Nothing in the beam of the light barrier; false where there is none."""
    monitor_connected: bool
    spo2_percent: float | None
    heart_rate_per_min: float | None
    airway_pressure_cmh2o: float | None


class HomedFound(NamedTuple):
    """Homing of an axis."""

    axis: str
    """``insertion`` or ``valve``."""
    unit: str
    method: int
    """Object 0x6098."""
    at: float
    """Position of the home, by the device file."""
    before: float
    """Position that the drive had taken itself to be at."""
    by_drive: float
    """And has afterwards."""
    by_second_sensor: float | None
    """Afterwards; None: the axis has none, or it tells nothing."""
    problem: str
    """Empty: there is none."""


class MoveFound(NamedTuple):
    """Small move of an axis."""

    axis: str
    """``insertion`` or ``valve``."""
    unit: str
    asked: float
    by_drive: float
    """By the encoder on the motor."""
    by_second_sensor: float | None
    """None: the axis has none, or it tells nothing, and a person has to look."""
    problem: str
    """Empty: there is none."""


class VacuumFound(NamedTuple):
    """Test of pump, regulator, sensor and vent."""

    asked_mmhg: float
    reached_mmhg: float
    left_mmhg: float
    """After the line was vented."""
    problem: str
    """Empty: there is none."""


class DeviceCheckResult(NamedTuple):
    """Result of a check."""

    ok: bool
    """There is no problem."""
    device: str
    """Name in the device file."""
    in_silico: bool
    """By the device file: its nodes are emulated."""
    interface: str
    channel: str
    nodes: tuple[NodeFound, ...]
    homed: tuple[HomedFound, ...]
    """Empty where none was asked for."""
    inputs: InputsFound
    """After homing, where that was asked for."""
    moves: tuple[MoveFound, ...]
    """Empty where none were asked for."""
    vacuum: VacuumFound | None
    """None where no moves were asked for."""
    problems: tuple[str, ...]
    """All of them, a sentence each."""
