"""The models that drive, fitted to recordings of a machine."""

import numpy as np

from opensuction.controller.calibration import Calibration
from opensuction.identification.judgement import drive_choice
from opensuction.identification.judgement.drive_choice import DriveChoice
from opensuction.simulation import rig as rigs
from opensuction.simulation.rig import IDENTIFICATION_RUN, Recording, Rig

EVERY = 10
"""Ticks from one sample to the next that is fitted: 100 Hz show all that the models follow."""


def choose(parts: tuple[Recording, ...], only_lines: bool) -> DriveChoice:
    """The model to drive by, of the excitation and the strokes after it.

    only_lines: of those with lines over their plays alone. Raises InputError where none drives.
    """
    whole = rigs.join(parts)
    head, tip = (
        np.ascontiguousarray(column[::EVERY]) for column in (whole.head_mm, whole.laser_mm)
    )
    return drive_choice.choose(head, tip, only_lines)


def with_lines(rig: Rig, calibration: Calibration) -> Calibration:
    """The calibration of a rig with the best of its models with lines, for `model-preview`.

    Excites the machine once more, with shorter strokes after the whole one. Raises InputError where
    no such model drives.
    """
    drive = choose(rigs.recordings(rig, IDENTIFICATION_RUN, inner=True), only_lines=True)
    assert drive.lines is not None
    return calibration._replace(lines=drive.lines)
