"""Bounds that a calibration must keep before a compensator may be driven by it.

Usual values are those of seeds 1 to 6 of both machines, in-silico.
"""

from typing import NamedTuple

import numpy as np

from opensuction.controller.machine_profile import MachineProfile
from opensuction.hysteresis import modified_dahl
from opensuction.procedure.cycle.plan import Excitation
from opensuction.settings.calibration_section import Validation
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.rig import Identification, Recording

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


def reasons(checks: tuple[CalibrationCheck, ...]) -> tuple[str, ...]:
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
