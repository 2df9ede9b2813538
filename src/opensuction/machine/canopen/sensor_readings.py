"""Readings of the sensors that a controller gets, by the newest that the nodes have said.

Positions count for the time at which they are read: a drive and the module have measured them at
the SYNC before, and at 60 mm/s the head has gone a quarter of a millimetre since.
"""

from collections.abc import Sequence

from opensuction.kernel.interface import LARGEST, Monitor, Readings
from opensuction.machine.canopen import device as units
from opensuction.machine.canopen.device import Analogue, Device, DriveAxis
from opensuction.machine.canopen.process_image import (
    INSERTION,
    MODULE,
    NEVER_S,
    RAILS,
    VALVE,
    AxisImage,
    ModuleImage,
    ProcessImage,
)


def readings(
    device: Device, image: ProcessImage, said: Sequence[str], now_s: float = NEVER_S
) -> Readings:
    """Readings that the controller gets.

    said: `complaints`. now_s: time for which positions count; without it, as they came.
    """
    insertion, valve = image.axes
    head_mm, head_valid = _position(device, device.insertion, insertion, now_s)
    cam_rad, cam_valid = _position(device, device.valve, valve, now_s)
    inputs, wired = device.module, not said[MODULE]
    carriage_mm, carriage_valid = _value(inputs.carriage, image.module)
    carriage_mm += _since(device, image.module, now_s)
    vacuum_mmhg, vacuum_valid = _value(inputs.vacuum, image.module)
    sound = not said[INSERTION]
    amperes = insertion.torque * 1e-3 * device.insertion.rated_current_a
    return Readings(
        head_mm=head_mm,
        head_valid=head_valid and sound,
        carriage_mm=carriage_mm,
        carriage_valid=carriage_valid and wired,
        cam_rad=cam_rad,
        cam_valid=cam_valid and not said[VALVE],
        line_vacuum_mmhg=vacuum_mmhg,
        vacuum_valid=vacuum_valid and wired,
        contact_closed=_bit(insertion.inputs, device.contact.closed_bit),
        contact_valid=_bit(insertion.inputs, device.contact.wired_bit) and sound,
        mouth_clear=_bit(image.module.digital, inputs.mouth_bit) and wired,
        insertion_current_a=-amperes if device.insertion.encoder.reversed else amperes,
        monitor=_monitor(device, image.module, wired),
    )


def _position(
    device: Device, axis: DriveAxis, image: AxisImage, now_s: float
) -> tuple[float, bool]:
    """Position in mm or rad, and True where an axis can be there: within twice its range.

    A drive answers SYNC with where it is then, and that is read a period later: by its speed it
    has gone on meanwhile, and as far again while a frame is missing.
    """
    found = units.position_of(axis, image.counts)
    if now_s >= image.status_s > NEVER_S:
        age_s = _age_s(device, image.status_s, now_s)
        speed = image.velocity / axis.counts_per_unit
        found += min(max(speed, -axis.most_per_s), axis.most_per_s) * age_s
    span = axis.highest - axis.lowest
    if not axis.lowest - span <= found <= axis.highest + span:
        return min(max(found, -LARGEST), LARGEST), False
    return found, True


def _value(channel: Analogue, module: ModuleImage) -> tuple[float, bool]:
    """Value of an analogue input, and True where it can be one; 0 where there is none."""
    if channel.channel == 0:
        return 0.0, False
    counts = module.analogue[channel.channel - 1]
    return units.value_of(channel, counts), counts not in RAILS


def _since(device: Device, module: ModuleImage, now_s: float) -> float:
    """Way of the head by its second sensor's own speed since that was read, in mm.

    It is held against the position of the encoder, which is carried on, too.
    """
    carriage = device.module.carriage
    place = carriage.channel - 1
    if place < 0 or not now_s >= module.analogue_s[place // 4] > NEVER_S:
        return 0.0
    most = device.insertion.most_per_s
    speed = module.rates[place] / carriage.counts_per_unit
    return min(max(speed, -most), most) * _age_s(device, module.analogue_s[place // 4], now_s)


def _age_s(device: Device, came_s: float, now_s: float) -> float:
    """Age of a reading: it was measured at the SYNC before, and may be missing for a period."""
    period_s = device.bus.period_s
    return period_s + min(now_s - came_s, period_s)


def _bit(word: int, bit: int) -> bool:
    """A digital input; false where the machine does not have it."""
    return bit >= 0 and bool(word >> bit & 1)


def _monitor(device: Device, module: ModuleImage, wired: bool) -> Monitor:
    inputs = device.module
    connected = _bit(module.digital, inputs.monitor_bit) and wired
    channels = (inputs.spo2, inputs.heart_rate, inputs.airway_pressure)
    values = []
    for channel, bit in zip(channels, inputs.validity_bits, strict=True):
        value, valid = _value(channel, module)
        values.append((value, valid and connected and _bit(module.digital, bit)))
    (spo2, spo2_valid), (rate, rate_valid), (pressure, pressure_valid) = values
    return Monitor(
        connected=connected,
        spo2_percent=spo2,
        spo2_valid=spo2_valid,
        heart_rate_per_min=rate,
        heart_rate_valid=rate_valid,
        airway_pressure_cmh2o=pressure,
        airway_pressure_valid=pressure_valid,
    )
