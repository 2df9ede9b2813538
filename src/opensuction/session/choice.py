"""Choices of a user as names, numbers and files; nothing is looked up here.

The command line fills these records as they are; each choice is resolved once, by the module that
uses it. The module imports nothing heavy, so that help and completion are quick.
"""

import math
from pathlib import Path
from typing import NamedTuple

LISTED = "'opensuction cycle --help'"
"""Where all names are that are too many for a message: faults, machines, compensations."""


class RigChoice(NamedTuple):
    """Machine and patient."""

    machine: str | None = None
    """Name of a preset or path of a TOML file; None: what the rest of the choice is for."""
    patient: str | None = None
    """Name of a preset or path of a TOML file; None: the default patient, nobody on the bench."""
    catheter: str | None = None
    """None: the one for the patient's age, or the machine file's."""
    conduit: str | None = None
    """None: the standard one, or the machine file's."""
    seed: int = 1
    """Draws both, and the noise of every measurement."""
    spread: float = 1.0
    """How many times as far from the nominal ones as usual both are drawn."""


class CycleChoice(NamedTuple):
    """One suction cycle."""

    rig: RigChoice = RigChoice()
    """Without a machine: the bench for a protocol that is for the bench only, else clinical."""
    protocol: str | None = None
    """Name of a preset or path of a TOML file; None: by the patient's age, the paper's on the
    bench."""
    approach: str = "travel"
    compensation: str = "preview"
    """Name of a compensator, or path of a parameter file that names one and holds its model."""
    taught_mm: float | None = None
    """Length that a person measured, tube's lower end to carina; None: taught by hand."""
    faults: tuple[str, ...] = ()
    """What goes wrong; see `session.cycle.resolution`."""
    gap_scale: float = 1.0
    """Of every gap width, changed after the identification: the conduit was laid otherwise."""
    tip_shift_mm: float = 0.0
    """By how much the tip lies deeper after the identification: the catheter was clamped anew."""
    preoxygenation: str | None = None
    """What a person answers before each cycle, confirmed or skipped; None: confirmed, on the twin
    given, where guidelines ask for it."""


class DayChoice(NamedTuple):
    """A day of cycles; by default there is one cycle and no day."""

    repeat: int = 1
    every_min: float | None = None
    """From start to start."""
    self_calibrates: bool = False
    """Gap and offset are measured in each cycle, and the next one compensates them."""

    @property
    def every_s(self) -> float:
        """From start to start; nan where nothing was said."""
        return math.nan if self.every_min is None else 60.0 * self.every_min


class CalibrationChoice(NamedTuple):
    """The calibration of a machine."""

    rig: RigChoice = RigChoice()
    """The patient, where there is one, only says where the machine parks and with what catheter."""
    compensation: str = "best"
    """Name of the compensator that the parameter file is for; best: the one whose model predicts
    best."""


class RecordingChoice(NamedTuple):
    """A recording, its columns, and the part of it that is used."""

    file: Path
    input: tuple[str, ...] = ()
    """Columns of what drives, the one that a machine moves first; none: not said."""
    output: str = ""
    """Column of what follows; "": not said."""
    time: str | None = None
    """Column of time; None: samples are evenly spaced."""
    negate_output: bool = False
    holdout: float = 0.0
    """Share from its end that is predicted instead of fitted."""
    from_s: float | None = None
    to_s: float | None = None
    input_unit: str | None = None
    """None: the one in the column's name."""
    output_unit: str | None = None
    time_unit: str | None = None
    """None: the one in the column's name, seconds where it has none."""
    skip_missing: bool = False
    """Rows in which a named column has no number are left out instead of refused."""
    sheet: str | None = None
    """Of an Excel workbook; None: the one that has rows of numbers."""


class PredictionChoice(NamedTuple):
    """A recording whose output a model predicts, its columns, and the part that is used."""

    file: Path
    parameter_file: Path
    """Of the model."""
    driven: tuple[str, ...] = ()
    """Columns of the model's inputs, in its order; none: as the parameter file names them."""
    measured: str | None = None
    """Column that is held against, "" for none; None: the one that the parameter file names, where
    it is."""
    time: str | None = None
    """Column of time; None: samples are evenly spaced."""
    from_s: float | None = None
    to_s: float | None = None
    input_unit: str | None = None
    """None: the one in the column's name."""
    time_unit: str | None = None
    """None: the one in the column's name, seconds where it has none."""
    skip_missing: bool = False
    """Rows in which a used column has no number are left out instead of refused."""
    sheet: str | None = None
    """Of an Excel workbook; None: the one that has rows of numbers."""
    with_interval: bool = False
    """Beside each predicted value the interval that holds 95 % of measured ones."""
