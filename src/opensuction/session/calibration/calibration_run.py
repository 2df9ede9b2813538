"""Calibration of a machine before use: excite, fit, excite again, and judge what was found.

The second run has other noise, and nothing is fitted to it: it says what the models are worth.

Bounds that a calibration must keep before a compensator may be driven by it.

Usual values are those of seeds 1 to 6 of both machines, in-silico.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.controller.machine_profile import MachineProfile
from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.bank import play_lines
from opensuction.identification.judgement import recommendation
from opensuction.identification.judgement.recommendation import DriveChoice
from opensuction.kernel.errors import InputError
from opensuction.procedure.cycle.plan import Excitation
from opensuction.session.choice import CalibrationChoice
from opensuction.session.cycle import equipment as equipments
from opensuction.session.cycle.equipment import Equipment
from opensuction.settings.calibration_section import Validation
from opensuction.settings.identification_file import ON_LINES
from opensuction.settings.validation import choose
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.rig import IDENTIFICATION_RUN, Identification, Recording, Rig

LEAST_STROKE = 0.95
"""Share of the stroke and of the time of the excitation that must have been recorded; usual .999
[design]."""
MOST_MODEL_RMSE_MM = 1.25
"""1.5 times the paper's .83 mm (section III-B); usual .65 to .9 mm."""
MOST_PLAYS_RMSE_MM = 0.25
"""Usual .09 mm, .08 of it the laser's noise; beyond, `preview` would lose half of its lead over the
modified Dahl model's .5 mm [design]."""
MOST_DIFFERENCE_MM = 0.3
"""Usual .11 mm. Two readings of a laser that is .1 mm good, the most that is assumed of it, differ
by .14 mm; as much again is left to the transmission [design]."""
GAP_RATIOS = (0.6, 1.4)
"""Gap over that of the machine as it was built; as the bounds of self-calibration [design]."""
MOST_SERVO_MM = 0.05
"""Head error that the servo's gain makes of the voltage that the feedforward leaves; usual .004 to
.011 mm; beyond, it would be half of what `preview` leaves [design]."""
SERVO_RATIOS = (0.7, 1.4)
"""Voltage for each mm/s over supply by the governor's speed limit, which is the machine's speed
without load; usual .98 to 1.1 [design]."""


class CalibrationCheck(NamedTuple):
    """One bound and what was found."""

    name: str
    value: float
    least: float | None
    most: float | None
    unit: str
    remedy: str

    @property
    def ok(self) -> bool:
        """True if the bound is kept; NaN keeps none."""
        return (self.least is None or self.value >= self.least) and (
            self.most is None or self.value <= self.most
        )


def of_stroke(
    excitation: Excitation, runs: tuple[Recording, Recording]
) -> tuple[CalibrationCheck, ...]:
    """Checks that both runs went through the whole excitation."""
    stroke = "free the head's way, then calibrate again"
    checks = []
    for name, recorded in zip(("first", "second"), runs, strict=True):
        head = recorded.head_mm
        range_mm = float(np.ptp(head)) if head.size else 0.0
        duration_s, least_s = head.size * DT_S, LEAST_STROKE * excitation.duration_s
        least_mm = LEAST_STROKE * excitation.range_mm
        checks += [
            CalibrationCheck(f"time of the {name} run", duration_s, least_s, None, "s", stroke),
            CalibrationCheck(f"stroke of the {name} run", range_mm, least_mm, None, "mm", stroke),
        ]
    return tuple(checks)


def of_inner_strokes(
    parts: tuple[Excitation, ...], runs: tuple[tuple[Recording, ...], tuple[Recording, ...]]
) -> tuple[CalibrationCheck, ...]:
    """Checks that both runs went through every shorter stroke after the excitation."""
    wanted_s = sum(part.duration_s for part in parts[1:])
    return tuple(
        CalibrationCheck(
            f"time of the shorter strokes of the {name} run",
            DT_S * sum(recorded.head_mm.size for recorded in run[1:]),
            LEAST_STROKE * wanted_s,
            None,
            "s",
            "free the head's way, then calibrate again",
        )
        for name, run in zip(("first", "second"), runs, strict=True)
    )


def of_lines(model: str, rmse_mm: float) -> CalibrationCheck:
    """Check that a model of plays with lines over them is as good as the plays have to be."""
    remedy = "calibrate with --compensation preview, or look for what changed between both runs"
    name = f"RMSE of the {model} model on the second run"
    return CalibrationCheck(name, rmse_mm, None, MOST_PLAYS_RMSE_MM, "mm", remedy)


def of_fit(
    profile: MachineProfile, found: Identification, validation: Validation
) -> tuple[CalibrationCheck, ...]:
    """Checks that models and servo are good enough and can be this machine's."""
    built_mm = float(modified_dahl.gap_mm(profile.transmission))
    gap_ratio = float(modified_dahl.gap_mm(found.fit.model)) / built_mm
    no_load = profile.supply_v / profile.head_limit_mm_per_s
    servo_mm = validation.servo_rmse_v / profile.insertion_p_v_per_mm
    look = "look for a loose laser or target, a catheter that slips, or a conduit that moves"
    route = "check catheter and how the conduit is laid, and name both"
    drive = "check the drive, its supply and the encoder's scale"
    model_mm, plays_mm = validation.model_rmse_mm, validation.plays_rmse_mm
    voltage_ratio = found.servo.velocity_v_s_per_mm / no_load
    voltage = "servo's voltage for speed over the nominal one"
    errors = (
        ("RMSE of the modified Dahl model on the second run", model_mm, MOST_MODEL_RMSE_MM),
        ("RMSE of the plays on the second run", plays_mm, MOST_PLAYS_RMSE_MM),
        ("RMS difference of both runs", validation.repeatability_mm, MOST_DIFFERENCE_MM),
    )
    return (
        *(CalibrationCheck(name, value, None, most, "mm", look) for name, value, most in errors),
        CalibrationCheck(
            "gap over the machine's nominal one", gap_ratio, *GAP_RATIOS, "mm/mm", route
        ),
        CalibrationCheck(
            "head error by the servo's fit", servo_mm, None, MOST_SERVO_MM, "mm", drive
        ),
        CalibrationCheck(voltage, voltage_ratio, *SERVO_RATIOS, "V/V", drive),
    )


def reasons_against(checks: tuple[CalibrationCheck, ...]) -> tuple[str, ...]:
    """A sentence for each bound that is not kept."""
    return tuple(_sentence(entry) for entry in checks if not entry.ok)


def bound(entry: CalibrationCheck) -> str:
    """The bound in words."""
    if entry.least is None:
        return f"at most {entry.most:g} {entry.unit}"
    if entry.most is None:
        return f"at least {entry.least:g} {entry.unit}"
    return f"{entry.least:g} to {entry.most:g} {entry.unit}"


def _sentence(entry: CalibrationCheck) -> str:
    name = entry.name[:1].upper() + entry.name[1:]
    return f"{name} is {entry.value:.3g} {entry.unit}, should be {bound(entry)}: {entry.remedy}."


BEST = "best"
"""Asks for the compensator whose model predicts best."""
OWN_COMPENSATOR = {recommendation.PLAYS: "preview", recommendation.DAHL: "exact-inverse"}
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
    checks = of_stroke(rig.profile.excitation, (first, second))
    reasons = reasons_against(checks)
    found, validation = None, None
    if not reasons:
        try:
            found = rigs.fitted(first, rig.profile.supply_v)
        except InputError as refused:
            reasons = (f"The recording does not determine the machine: {refused}.",)
    if found is not None:
        validation = validated(found, second)
        checks = (*checks, *of_fit(rig.profile, found, validation))
        reasons = reasons_against(checks)
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
    checks = of_inner_strokes(parts, (firsts, seconds))
    reasons = reasons_against(checks)
    found = found._replace(inner=firsts[1:], checks=(*found.checks, *checks), reasons=reasons)
    if reasons:
        return found
    try:
        drive = equipments.choose_model(firsts, only_lines=found.compensation == ON_LINES)
    except InputError as refused:
        return found._replace(reasons=(f"The machine cannot be driven so: {refused}.",))
    found = found._replace(compensation=OWN_COMPENSATOR.get(drive.model, ON_LINES), drive=drive)
    if drive.lines is None:
        return found
    calibration = identified.calibration._replace(lines=drive.lines)
    whole = rigs.join(seconds)
    tip_mm = play_lines.simulate(play_lines.tabulate(drive.lines), whole.head_mm)
    rmse_mm = _rms(whole.laser_mm - tip_mm)
    if found.compensation == ON_LINES:
        checks = (*found.checks, of_lines(drive.model, rmse_mm))
        found = found._replace(checks=checks, reasons=reasons_against(checks))
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
