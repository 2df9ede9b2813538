"""Device file: a machine on a CANopen bus in TOML, checked key by key.

Nothing in it has a default, and nothing is guessed: a node that answers to a wrong scale moves the
wrong way, or too far. What a file can say that no machine should do is refused here: a drive that
runs on after its host has died, a heartbeat of which one that is late trips the machine.
`emulated.toml` beside this module is the file of the emulated drives.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from os import PathLike
from pathlib import Path
from typing import Any, Final, NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.machine.canopen.device import (
    WRAP,
    Analogue,
    ContactInput,
    Device,
    DriveAxis,
    Heartbeats,
    InputModule,
)
from opensuction.machine.canopen.objects import AbortConnection
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import trim, validate
from opensuction.settings.wording import refuse

EMULATED: Final = Path(__file__).with_name("emulated.toml")
"""File of the emulated drives: where one of your own begins."""
NAME: Final = "device.toml"
"""The device file in a machine's folder."""


class _Quantity(NamedTuple):
    """Range of a quantity that an analogue channel carries."""

    most: float
    """Highest value that occurs."""
    unit: str


_INPUTS: Final = {
    "vacuum": _Quantity(200.0, "mmHg"),
    "carriage": _Quantity(350.0, "mm"),
    "spo2": _Quantity(100.0, "%"),
    "heart_rate": _Quantity(250.0, "1/min"),
    "airway_pressure": _Quantity(60.0, "cmH2O"),
}
_OUTPUT: Final = _Quantity(200.0, "mmHg")
_MONITORED: Final = ("spo2", "heart_rate", "airway_pressure")
OUTPUT_CHANNELS: Final = 2
"""Analogue outputs that a frame of the module carries."""
_FINEST_SHARE: Final = 1e-3
"""A channel tells at least so small a part of the highest value."""
_COARSEST: Final = {"insertion": (0.05, "mm"), "valve": (0.005, "rad")}
"""[design] Largest step of an axis' encoder: a fifth of what the controller takes for arrived."""
PERIODS_MS: Final = range(1, 11)
"""Periods of SYNC that drives interpolate over (0x60C2), in whole ms."""


def load(path: str | PathLike[str]) -> Device:
    """The machine that a device file describes.

    Raises InputError of one line for a file that cannot be read, an unknown or missing key, a value
    out of its range, and values that do not fit together.
    """
    given = load_toml(path)
    _freeze_bits(given)
    device = validate(Device, given, path)
    for problem in _problems(device):
        raise refuse(path, problem)
    return device


def find(folder: Path) -> Device:
    """The machine of a folder. Raises InputError as `load`, and where the folder has no file."""
    path = folder / NAME
    if not path.exists():
        raise InputError(f"{path}: no device file; a machine on a bus needs one in its folder")
    return load(path)


def _freeze_bits(given: dict[str, Any]) -> None:
    """Lists of a TOML file where a record holds a tuple."""
    module = given.get("module")
    if isinstance(module, dict) and isinstance(module.get("validity_bits"), list):
        module["validity_bits"] = tuple(module["validity_bits"])


def _problems(device: Device) -> Iterator[str]:
    """Each thing in a device that no machine can be driven by, with the remedy."""
    period_ms = 1000.0 * device.bus.period_s
    if not any(abs(period_ms - ms) < 1e-9 for ms in PERIODS_MS):
        yield (
            f"bus.period_s is {device.bus.period_s:g}: drives interpolate over whole ms; give one "
            f"of 0.001 to {PERIODS_MS[-1] / 1000:g} s in steps of 0.001"
        )
    yield from _node_problems(device)
    yield from _heartbeat_problems(device.heartbeats, period_ms)
    for name in ("insertion", "valve"):
        yield from _axis_problems(name, getattr(device, name))
    yield from _contact_problems(device.contact)
    yield from _module_problems(device.module)


def _node_problems(device: Device) -> Iterator[str]:
    """Two participants of a bus with one number."""
    numbers = {
        "host_node": device.host_node,
        "insertion.node": device.insertion.node,
        "valve.node": device.valve.node,
        "module.node": device.module.node,
    }
    yield from _shared(numbers, "participant", "number")


def _shared(given: Mapping[str, int], what: str, of_its_own: str) -> Iterator[str]:
    """A number that two keys have."""
    for number, times in Counter(given.values()).items():
        if times > 1:
            names = [name for name, one in given.items() if one == number]
            keys = f"{', '.join(names[:-1])} and {names[-1]}"
            every = "both" if times == 2 else "all"
            yield f"{keys} are {every} {number}; give each {what} a {of_its_own} of its own"


def _heartbeat_problems(beats: Heartbeats, period_ms: float) -> Iterator[str]:
    """Times of which one late heartbeat trips the machine."""
    if beats.host_ms < period_ms:
        yield (
            f"heartbeats.host_ms is {beats.host_ms}, less than a period of {period_ms:g} ms, once "
            f"in which it is given at most; give {period_ms:g} or more"
        )
    for often, patience, who in (
        ("host_ms", "lost_host_ms", "host"),
        ("node_ms", "lost_node_ms", "node"),
    ):
        every_ms, lost_ms = getattr(beats, often), getattr(beats, patience)
        if lost_ms <= 2 * every_ms + period_ms:
            yield (
                f"heartbeats.{patience} is {lost_ms}: a single heartbeat that is lost would lose "
                f"the {who}; give more than {2 * every_ms + period_ms:g} (twice {often} and a "
                "period)"
            )


def _axis_problems(name: str, axis: DriveAxis) -> Iterator[str]:
    """An axis that would not move as it is told, or not stop."""
    if axis.lost_host == AbortConnection.NOTHING:
        yield (
            f"{name}.lost_host is 'nothing': the motor would run on after the host has died; give "
            "'withdraw', 'quick-stop', 'disable-voltage' or 'fault'"
        )
    if not axis.lowest < axis.highest:
        yield (
            f"{name}.lowest is {axis.lowest:g}, not below {name}.highest of {axis.highest:g}; give "
            "the range of positions from the lower end to the higher"
        )
    elif not axis.lowest <= 0.0 <= axis.highest:
        yield (
            f"{name}.lowest and {name}.highest leave out 0, where the axis rests; give a range "
            "with 0 in it"
        )
    counts = abs(axis.counts_per_unit)
    coarsest, unit = _COARSEST[name]
    if counts * coarsest < 1.0:
        yield (
            f"{name}.encoder gives {counts:g} counts for each {unit}, coarser than {coarsest:g} "
            f"{unit}; check counts_per_turn, gear_ratio and travel_per_turn"
        )
    if not axis.lowest <= axis.homing.at <= axis.highest:
        yield (
            f"{name}.homing.at is {axis.homing.at:g}, beyond the axis' range; give a position from "
            f"{name}.lowest to {name}.highest"
        )
    if axis.homing.slow_per_s > axis.homing.per_s or axis.homing.per_s > axis.most_per_s:
        yield (
            f"{name}.homing has speeds of {axis.homing.per_s:g} and {axis.homing.slow_per_s:g}; "
            f"give {name}.most_per_s of {axis.most_per_s:g} at most, and slow_per_s the lower"
        )
    if counts * axis.following_window >= WRAP - 1:
        yield (
            f"{name}.following_window is {axis.following_window:g}, more than 32 bits hold; give "
            "less, or 0 for none"
        )
    if counts * max(abs(axis.lowest), abs(axis.highest)) >= WRAP // 2:
        yield (
            f"{name}.encoder gives {counts:g} counts for each {unit}: 32 bits do not hold the "
            "range; check counts_per_turn, gear_ratio and travel_per_turn"
        )


def _contact_problems(contact: ContactInput) -> Iterator[str]:
    """A contact switch that stops nothing by itself, or whose line nobody watches."""
    if contact.closed_bit == contact.wired_bit:
        yield (
            f"contact.closed_bit and contact.wired_bit are both {contact.wired_bit}; give each "
            "input a bit of its own"
        )
    if not contact.stop:
        yield (
            "contact.stop is empty: without a host the motor would run on after contact; give the "
            "maker's objects that arm the insertion drive's own stop on that input"
        )
    for number, one in enumerate(contact.stop, 1):
        if one.value >> one.bits:
            yield (
                f"contact.stop[{number}].value is {one.value:#x}, which {one.bits} bits do not "
                "hold; give the object's length in bits and its value"
            )


def _module_problems(module: InputModule) -> Iterator[str]:
    """Inputs and outputs that are not there, are there twice, or cannot hold their quantity."""
    for name in ("vacuum", "regulator"):
        if getattr(module, name).channel == 0:
            yield f"module.{name}.channel is 0, but no machine does without; give its channel"
    inputs = {f"module.{name}.channel": getattr(module, name).channel for name in _INPUTS}
    present = {key: channel for key, channel in inputs.items() if channel}
    yield from _shared(present, "analogue input", "channel")
    bits = {
        "module.mouth_bit": module.mouth_bit,
        "module.monitor_bit": module.monitor_bit,
        **{f"module.validity_bits[{k}]": bit for k, bit in enumerate(module.validity_bits)},
    }
    yield from _shared({key: bit for key, bit in bits.items() if bit >= 0}, "input", "bit")
    if module.regulator.channel > OUTPUT_CHANNELS:
        yield (
            f"module.regulator.channel is {module.regulator.channel}; give an analogue output from "
            f"1 to {OUTPUT_CHANNELS}"
        )
    for name, validity in zip(_MONITORED, module.validity_bits, strict=True):
        if getattr(module, name).channel and (module.monitor_bit < 0 or validity < 0):
            yield (
                f"module.{name} has a channel, but monitor_bit or its bit of validity_bits is -1: "
                "its value would never count; give both bits, or channel = 0"
            )
    for name, quantity in {**_INPUTS, "regulator": _OUTPUT}.items():
        yield from _channel_problems(f"module.{name}", getattr(module, name), quantity)


def _channel_problems(key: str, channel: Analogue, quantity: _Quantity) -> Iterator[str]:
    """A scale by which 16 bits do not hold a quantity, or tell nothing of it."""
    if channel.channel == 0:
        return
    scale, most, unit = channel.counts_per_unit, quantity.most, quantity.unit
    if abs(scale) * most * _FINEST_SHARE < 1.0:
        yield (
            f"{key}.counts_per_unit is {scale:g}: a count would be more than a thousandth of "
            f"{trim(most)} {unit}; give at least {1.0 / (most * _FINEST_SHARE):.3g}"
        )
    elif not -0x8000 <= channel.zero_counts + scale * most <= 0x7FFF:
        yield (
            f"{key}.counts_per_unit is {scale:g}: 16 bits hold no {trim(most)} {unit} from "
            f"zero_counts = {channel.zero_counts} on; give less"
        )
