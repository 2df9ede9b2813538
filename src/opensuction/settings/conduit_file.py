"""Conduits that the project ships: parameters fitted to real recordings, a TOML file each.

The files stand in `conduit` beside this module. A file holds what was fitted, how well it describes
its recording and how far repeats of that recording lie apart; the recording itself is not in it.
`text` writes one, from a recording in degrees.

A transmission by the name of its class.
"""

import tomllib
from collections.abc import Iterable
from functools import lru_cache
from importlib import resources
from typing import NamedTuple

import numpy as np

from opensuction.kernel.record import Array
from opensuction.settings.validation import choose
from opensuction.twin.conduit import conduit_fit, play_line
from opensuction.twin.conduit.play_line import RecordedConduit, TransmissionClass

RUNS = ("00", "25", "45")
"""Of tool 4 under load 4: sines of .1, .3 and .5 Hz."""
PREISACH = tuple(f"preisach-{run}" for run in RUNS)
"""Spindle to jaw, a Preisach model."""
READOUT = tuple(f"readout-{run}" for run in RUNS)
"""Motor to jaw, the gear before the spindle with it, a play readout."""
NAMES = (*PREISACH, *READOUT)
HEADING = """\
# A conduit fitted to a real recording: parameters derived from data, not the data.
# Recording: MRDLab/mis-tool-characterization, University of Minnesota; O'Neill, Stephens,
# Kowalewski, IEEE Robotics and Automation Letters 2018, doi 10.1109/LRA.2018.2849862.
# Its licence: Open Database License 1.0, contents Database Contents License 1.0.
# Fitted by opensuction.twin.conduit.conduit_fit; mm are degrees times mm_per_deg.
"""


class ShippedConduit(NamedTuple):
    """A conduit with where it comes from."""

    conduit: RecordedConduit
    recording: str
    input: str
    """Column of the recording that drives."""
    mm_per_deg: float
    residual_mm: float
    """What the conduit leaves of its recording, RMS."""
    scatter_mm: float
    """How far repeats of that recording lie apart: its floor."""


def source(name: str) -> tuple[str, str, float]:
    """Recording, its column that drives, and the sign of its jaw angle that rises with it."""
    run = name[-2:]
    recording = f"tool4_L4_{run}"
    return (recording, "spindle_deg", -1.0) if name in PREISACH else (recording, "motor_deg", 1.0)


def fit(name: str, input_deg: Array, jaw_deg: Array) -> ShippedConduit:
    """A shipped conduit anew from its recording, once the load is on; shape (n,) each."""
    recording, column, sign = source(name)
    head_mm, tip_mm = conduit_fit.scale(input_deg, sign * jaw_deg)
    found = conduit_fit.fit(name.split("-", maxsplit=1)[0], head_mm, tip_mm)
    return ShippedConduit(
        conduit=found.conduit,
        recording=recording,
        input=column,
        mm_per_deg=conduit_fit.STROKE_MM / float(np.ptp(input_deg)),
        residual_mm=found.residual_mm,
        scatter_mm=conduit_fit.scatter_mm(head_mm, tip_mm),
    )


def text(shipped: ShippedConduit) -> str:
    """The file of a conduit; numbers to a micrometre or a part in a hundred thousand."""
    conduit = shipped.conduit
    gains = [np.trim_zeros(np.round(row, 5), "b") for row in conduit.gains]
    rows = "".join(f"  [{_numbers(row)}],\n" for row in gains)
    return (
        f'{HEADING}recording = "{shipped.recording}"\ninput = "{shipped.input}"\n'
        f"mm_per_deg = {shipped.mm_per_deg:.6g}\n"
        f"residual_mm = {shipped.residual_mm:.4f}  # RMS of what it leaves of the recording\n"
        f"scatter_mm = {shipped.scatter_mm:.4f}  # standard deviation of repeated strokes\n"
        f"goes_on = {str(conduit.goes_on).lower()}  # beyond its ends a line goes on, or is level\n"
        f"cell_mm = {conduit.cell_mm:.6g}\noffset_mm = {conduit.offset_mm:.4f}\n"
        f"widths_mm = [{_numbers(conduit.widths_mm)}]\nlows_mm = [{_numbers(conduit.lows_mm)}]\n"
        "# Slopes of the lines, mm of tip per mm of play; a row a play, trailing zeros cut.\n"
        f"gains = [\n{rows}]\n"
    )


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.5g}" for value in values)


@lru_cache(maxsize=len(NAMES))
def load(name: str) -> ShippedConduit:
    """One of the conduits by name, one of `NAMES`."""
    file = resources.files("opensuction.settings") / "conduit" / f"{name}.toml"
    given = tomllib.loads(file.read_text(encoding="utf-8"))
    rows = given["gains"]
    gains = np.zeros((len(rows), round(conduit_fit.STROKE_MM / given["cell_mm"])))
    for number, row in enumerate(rows):
        gains[number, : len(row)] = row
    conduit = RecordedConduit(
        widths_mm=np.array(given["widths_mm"], dtype=np.float64),
        lows_mm=np.array(given["lows_mm"], dtype=np.float64),
        cell_mm=float(given["cell_mm"]),
        gains=gains,
        goes_on=given["goes_on"],
        offset_mm=float(given["offset_mm"]),
    )
    names = ("recording", "input", "mm_per_deg", "residual_mm", "scatter_mm")
    return ShippedConduit(conduit, *(given[key] for key in names))


@lru_cache(maxsize=len(NAMES))
def smoothed(name: str) -> tuple[TransmissionClass, float]:
    """One of the conduits as the twin has it, and what that form loses, RMS in mm."""
    lines, offset_mm, lost_mm = play_line.smooth(load(name).conduit)
    return play_line.recorded(name, lines, offset_mm), lost_mm


BUILT = {
    one.name: one
    for one in (
        play_line.SUM_OF_PLAYS,
        play_line.BOUC_WEN,
        play_line.RUBBING,
    )
}
"""Classes that the machine's parameters describe whole."""
TRANSMISSION_NAMES = (*BUILT, *NAMES)
MACHINES = {
    f"bench-{name}": name for name in TRANSMISSION_NAMES if name != play_line.SUM_OF_PLAYS.name
}
"""Machines by name that are the bench with a transmission of another class."""


def find(name: object) -> TransmissionClass:
    """A class by name; raises InputError with the nearest for one that is not known."""
    known = choose(name, {one: one for one in TRANSMISSION_NAMES}, "transmission")
    return BUILT[known] if known in BUILT else smoothed(known)[0]
