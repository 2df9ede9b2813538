"""Calibration of a machine before use: excite, fit, excite again, and judge what was found.

The second run has other noise, and nothing is fitted to it: it says what the models are worth.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.bank import play_table
from opensuction.identification.judgement import drive_choice
from opensuction.identification.judgement.drive_choice import DriveChoice
from opensuction.kernel.errors import InputError
from opensuction.session.calibration import calibration_check
from opensuction.session.calibration.calibration_check import CalibrationCheck
from opensuction.session.choice import CalibrationChoice
from opensuction.session.cycle import driving
from opensuction.session.cycle import equipment as equipments
from opensuction.session.cycle.equipment import Equipment
from opensuction.settings.calibration_section import Validation
from opensuction.settings.choice import choose
from opensuction.settings.identification_file import ON_LINES
from opensuction.simulation import rig as rigs
from opensuction.simulation.rig import IDENTIFICATION_RUN, Identification, Recording, Rig

BEST = "best"
"""Asks for the compensator whose model predicts best."""
OWN_COMPENSATOR = {drive_choice.PLAYS: "preview", drive_choice.DAHL: "exact-inverse"}
"""Of models that drive in a form of their own; all others do by `ON_LINES`."""
VALIDATION_RUN = 4
"""Number of the noise stream of the second run; cycles and teaching have others."""
UNDETERMINED = (
    "The run does not determine how fast the lag decays, so that gap and gain trade against each "
    "other: check that the tip follows the head."
)
WOULD_JUMP = (
    "The model has no continuous inverse (its slope is not above twice its velocity_gain), so that "
    "direct-inverse would jump at each reversal: calibrate with --compensation exact-inverse, or "
    "run it as printed with opensuction cycle --compensation direct-inverse."
)


class Calibrated(NamedTuple):
    """A calibration, accepted or not."""

    equipment: Equipment
    compensation: str
    rig: Rig
    first: Recording
    """The excitation, which plays, curves and servo were fitted to."""
    second: Recording
    """What they were held against."""
    found: Identification | None
    """None where the recording did not determine a model."""
    validation: Validation | None
    checks: tuple[CalibrationCheck, ...]
    """Every bound with its value."""
    reasons: tuple[str, ...]
    """Why it is refused, in sentences; empty where it is accepted."""
    drive: DriveChoice | None = None
    """How the models were held against one another; None where one compensator was asked for that
    needs no choice."""
    driven_rmse_mm: float | None = None
    """What the model with lines leaves of the second run; None without one."""
    inner: tuple[Recording, ...] = ()
    """Shorter strokes after the first run, where a choice was made."""

    @property
    def whole(self) -> Recording:
        """All of the first run."""
        return rigs.join((self.first, *self.inner))

    @property
    def accepted(self) -> bool:
        """True if a compensator may use the calibration."""
        return not self.reasons

    @property
    def predicted(self) -> tuple[npt.NDArray[np.float64], ...] | None:
        """Prediction of the second run; None where no model was found."""
        return None if self.found is None else predict(self.found, self.second)


def resolve(choice: CalibrationChoice) -> Equipment:
    """Equipment that was chosen; raises InputError for unknown names and bad files."""
    equipment = equipments.resolve(choice.rig)
    usable = [name for name, kind in KIND_OF_NAME.items() if kind != CompensationKind.NONE]
    choose(choice.compensation, dict.fromkeys((BEST, *usable)), "compensation")
    return equipment


def run(choice: CalibrationChoice, tell: Callable[[str], None] = lambda _: None) -> Calibrated:
    """Calibrate the machine that the seed draws, nobody on it.

    tell: called with a line of progress. Raises InputError for bad names and files; a poor fit
    is no error but a refusal in the result.
    """
    equipment = resolve(choice)
    rig = equipment.draw()
    inner = choice.compensation in (BEST, ON_LINES)
    tell("Exciting the machine: the head over its stroke and back, twice, the tip under a laser")
    firsts = rigs.recordings(rig, IDENTIFICATION_RUN, inner)
    tell("Exciting it again, to hold the models against what they have not seen")
    seconds = rigs.recordings(rig, VALIDATION_RUN, inner)
    found = judged(equipment, choice.compensation, rig, firsts[0], seconds[0])
    if not (inner and found.accepted and found.found is not None):
        return found
    tell("Holding every model that drives against the others, on strokes left out in turn")
    return _driven(found, found.found, firsts, seconds)


def judged(
    equipment: Equipment, compensation: str, rig: Rig, first: Recording, second: Recording
) -> Calibrated:
    """Fit the first recording, hold the result against the second, and judge it."""
    checks = calibration_check.of_stroke(rig.profile.excitation, (first, second))
    reasons = calibration_check.reasons(checks)
    found, validation = None, None
    if not reasons:
        try:
            found = rigs.fitted(first, rig.profile.supply_v)
        except InputError as refused:
            reasons = (f"The recording does not determine the machine: {refused}.",)
    if found is not None:
        validation = validated(found, second)
        checks = (*checks, *calibration_check.of_fit(rig.profile, found, validation))
        reasons = calibration_check.reasons(checks)
        if not found.fit.determined:
            reasons = (*reasons, UNDETERMINED)
        if compensation == "direct-inverse" and not found.fit.well_posed:
            reasons = (*reasons, WOULD_JUMP)
    return Calibrated(
        equipment, compensation, rig, first, second, found, validation, checks, reasons
    )


def _driven(
    found: Calibrated,
    identified: Identification,
    firsts: tuple[Recording, ...],
    seconds: tuple[Recording, ...],
) -> Calibrated:
    """A calibration that holds, with the compensator that its models drive best by.

    firsts, seconds: the excitation and the shorter strokes after it, of either run.
    """
    parts = rigs.strokes(found.rig.profile.excitation, inner=True)
    checks = calibration_check.of_inner_strokes(parts, (firsts, seconds))
    reasons = calibration_check.reasons(checks)
    found = found._replace(inner=firsts[1:], checks=(*found.checks, *checks), reasons=reasons)
    if reasons:
        return found
    try:
        drive = driving.choose(firsts, only_lines=found.compensation == ON_LINES)
    except InputError as refused:
        return found._replace(reasons=(f"The machine cannot be driven so: {refused}.",))
    found = found._replace(compensation=OWN_COMPENSATOR.get(drive.model, ON_LINES), drive=drive)
    if drive.lines is None:
        return found
    calibration = identified.calibration._replace(lines=drive.lines)
    whole = rigs.join(seconds)
    tip_mm = play_table.simulate(play_table.tabulate(drive.lines), whole.head_mm)
    rmse_mm = _rms(whole.laser_mm - tip_mm)
    if found.compensation == ON_LINES:
        checks = (*found.checks, calibration_check.of_lines(drive.model, rmse_mm))
        found = found._replace(checks=checks, reasons=calibration_check.reasons(checks))
    return found._replace(
        found=identified._replace(calibration=calibration), driven_rmse_mm=rmse_mm
    )


def validated(found: Identification, second: Recording) -> Validation:
    """Errors of an identification on another recording."""
    model_mm, plays_mm = predict(found, second)
    samples = min(second.laser_mm.size, found.laser_mm.size)
    return Validation(
        model_rmse_mm=_rms(second.laser_mm - model_mm),
        plays_rmse_mm=_rms(second.laser_mm - plays_mm),
        repeatability_mm=_rms(second.laser_mm[:samples] - found.laser_mm[:samples]),
        servo_rmse_v=found.servo.rmse_v,
    )


def predict(found: Identification, recorded: Recording) -> tuple[npt.NDArray[np.float64], ...]:
    """Tip by the modified Dahl model and by the plays, mm, for the heads of a recording."""
    head = recorded.head_mm
    plays = found.plays.model
    start = prandtl_ishlinskii.retracted_positions_mm(plays, head[0])
    return (
        modified_dahl.simulate(found.fit.model, head, found.fit.lag_mm),
        prandtl_ishlinskii.simulate(plays, head, start),
    )


def _rms(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
    return float(np.sqrt(np.mean(values * values)))
