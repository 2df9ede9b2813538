"""Warnings of a cycle that no alarm gives, a sentence each."""

from opensuction.control.compensation import CompensationKind
from opensuction.hysteresis import modified_dahl
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.outcome import Outcome

SECRETION_SHARE_PERCENT = 80.0
"""Share of the secretions below which the report says why there is some left."""
LEAST_SHARE_PERCENT = 5.0
"""Share below which nothing was removed to speak of: depth and time do not explain that."""
BUDGET_MARGIN_S = 0.05
"""Timing that exceeds the guideline by less is rounding of a tick or two."""


def warnings(prepared: Prepared, result: Outcome) -> list[str]:
    """The key ``warnings``: suction too long or without effect, a model or file that lacks much."""
    found = (
        _of_suction(prepared, result),
        _of_secretion(result),
        _of_servo(prepared),
        _of_model(prepared),
    )
    return [sentence for sentence in found if sentence is not None]


def _of_suction(prepared: Prepared, result: Outcome) -> str | None:
    """Warning of suction longer than guidelines allow."""
    guideline_s = GUIDELINES[prepared.rig.site.age].negative_pressure_s
    if not result.negative_pressure_s > guideline_s + BUDGET_MARGIN_S:  # true of NaN
        return None
    planned = prepared.protocol.negative_pressure_budget_s > guideline_s + BUDGET_MARGIN_S
    return (
        f"Suction lasted {result.negative_pressure_s:.1f} s: guidelines allow "
        f"{guideline_s:g} s." + (" This protocol is for the bench only." if planned else "")
    )


def _of_secretion(result: Outcome) -> str | None:
    """Warning of secretions that are left after a completed cycle, with the reason."""
    if not (result.completed and result.removed_percent < SECRETION_SHARE_PERCENT):
        return None
    if result.removed_percent < LEAST_SHARE_PERCENT:
        return (
            f"Only {result.removed_percent:.0f} % of the secretions were removed: suction was "
            "without effect."
        )
    return (
        f"Only {result.removed_percent:.0f} % of the secretions were removed: the rest lies "
        "deeper than the tip may go, or did not come within the "
        f"{result.negative_pressure_s:.1f} s of suction."
    )


def _of_servo(prepared: Prepared) -> str | None:
    """Warning of a nominal feedforward where a parameter file has none."""
    file = prepared.resolved.parameter_file
    if file is None or file.servo is not None:
        return None
    return (
        "The parameter file holds no servo feedforward: the motor's nominal voltage for speed "
        "stands in for it, and nothing for friction; a calibration of the machine finds both."
    )


def _of_model(prepared: Prepared) -> str | None:
    """Warning of a modified Dahl model without an inverse, with what its compensator does."""
    kind, model = prepared.resolved.compensation, prepared.calibration.model
    on_dahl = kind in (CompensationKind.DIRECT_INVERSE, CompensationKind.EXACT_INVERSE)
    if not on_dahl or modified_dahl.is_monotone(model):
        return None
    crossing = "; the reversal is crossed as a gap."
    if kind == CompensationKind.DIRECT_INVERSE:
        crossing = ", and the printed compensator jumps there."
    return (
        f"The identified model is not monotone (c = {model.slope:.3f} is not above 2 beta = "
        f"{2 * model.velocity_gain:.3f}): at a reversal it has no continuous inverse{crossing}"
    )
