"""Key figures of a cycle, each beside its limit and with a verdict in words."""

from enum import Enum
from typing import NamedTuple

from opensuction.report.summary import Summary, number, text
from opensuction.report.wording import quantity


class FigureVerdict(Enum):
    """How a figure stands against its limit."""

    GOOD = "good"
    NOTICE = "notice"
    """Outside a recommendation, inside the limit that was set."""
    BAD = "bad"
    NEUTRAL = "neutral"
    """There is no limit to hold it against."""
    ABSENT = "absent"


ATTENTION = (FigureVerdict.NOTICE, FigureVerdict.BAD)
"""Verdicts that a person should look at."""


class Figure(NamedTuple):
    """One key figure."""

    name: str
    value: str
    limit: str
    """What it is held against, or a remark; may be empty."""
    verdict: FigureVerdict
    remark: str
    """The verdict in words; may be empty."""


def _against(value: float | None, limit: float | None, words: str) -> tuple[FigureVerdict, str]:
    """Verdict on a value that shall not exceed a limit; ``words`` names the limit."""
    if value is None:
        return FigureVerdict.ABSENT, ""
    if limit is None:
        return FigureVerdict.NEUTRAL, ""
    if value > limit:
        return FigureVerdict.BAD, f"over the {words}"
    return FigureVerdict.GOOD, f"within the {words}"


def _known(words: str, value: float | None, unit: str, decimals: int = 1) -> list[str]:
    """A quantity with the word before it, where it is known."""
    return [] if value is None else [f"{words} {quantity(value, unit, decimals)}"]


def deepest_tip(summary: Summary) -> Figure:
    """Deepest position of the tip against its cap."""
    deepest, cap = number(summary, "tip", "deepest_mm"), number(summary, "anatomy", "cap_mm")
    limit = "" if cap is None else f"cap {quantity(cap, 'mm')} below the tube's end"
    verdict = _against(deepest, cap, "cap")
    return Figure("Deepest tip position", quantity(deepest, "mm"), limit, *verdict)


def stop_error(summary: Summary) -> Figure:
    """Where the tip stopped against the target.

    Tolerance is the margin to the cap; where the carina was to be touched and left again, the
    distance by which it was to be left.
    """
    error = number(summary, "tip", "stop_error_mm")
    target, cap = number(summary, "tip", "target_mm"), number(summary, "anatomy", "cap_mm")
    limit = "" if target is None else f"target {quantity(target, 'mm')}"
    if error is None or target is None or cap is None:
        return _without_limit("Stopping error", error, "mm", beside=limit, signed=True)
    tolerance, whose = cap - target, "cap"
    carina = number(summary, "anatomy", "carina_mm")
    if text(summary, "approach") == "contact" and carina is not None and carina > target:
        tolerance, whose = carina - target, "carina"
    limit += f", margin to the {whose} {quantity(tolerance, 'mm')}"
    verdict, remark = FigureVerdict.GOOD, "at the target"
    if error < -tolerance:
        verdict, remark = FigureVerdict.NOTICE, "short of the target"
    elif error > tolerance:
        verdict, remark = FigureVerdict.BAD, "beyond the target"
    return Figure("Stopping error", quantity(error, "mm", signed=True), limit, verdict, remark)


def negative_pressure(summary: Summary) -> Figure:
    """How long suction lasted against the protocol's budget and the guideline's limit."""
    lasted = number(summary, "timing", "negative_pressure_s")
    budget = number(summary, "timing", "negative_pressure_budget_s")
    guideline = number(summary, "timing", "guideline_s")
    verdict, remark = _against(lasted, budget, "protocol's limit")
    beyond = lasted is not None and guideline is not None and lasted > guideline
    if beyond and verdict is not FigureVerdict.BAD:
        verdict, remark = FigureVerdict.NOTICE, "over the guideline"
    limits = [*_known("limit", budget, "s"), *_known("guideline", guideline, "s")]
    name = "Time under negative pressure"
    return Figure(name, quantity(lasted, "s"), ", ".join(limits), verdict, remark)


def in_airway(summary: Summary) -> Figure:
    """How long the catheter was in the airway."""
    lasted = number(summary, "timing", "in_airway_s")
    budget = number(summary, "timing", "in_airway_budget_s")
    limit = "".join(_known("limit", budget, "s"))
    return Figure(
        "Time in the airway", quantity(lasted, "s"), limit, *_against(lasted, budget, "limit")
    )


def carina_force(summary: Summary) -> Figure:
    """Highest force on the carina."""
    force = number(summary, "carina_force_peak_n")
    verdict, remark = FigureVerdict.NEUTRAL, "contact, as wanted"
    if force is None:
        verdict, remark = FigureVerdict.ABSENT, ""
    elif force == 0.0:
        verdict, remark = FigureVerdict.GOOD, "no contact"
    elif text(summary, "approach") == "travel":
        verdict, remark = FigureVerdict.NOTICE, "contact, and none was wanted"
    return Figure("Force on the carina", quantity(force, "N", 2), "", verdict, remark)


def _without_limit(
    name: str,
    value: float | None,
    unit: str,
    decimals: int = 1,
    beside: str = "",
    signed: bool = False,
) -> Figure:
    """A figure that there is no limit for. beside: what is said instead of one."""
    verdict = FigureVerdict.ABSENT if value is None else FigureVerdict.NEUTRAL
    return Figure(name, quantity(value, unit, decimals, signed=signed), beside, verdict, "")


def figures(summary: Summary) -> list[Figure]:
    """Key figures, what matters most to the patient first."""
    pressure = number(summary, "airway_pressure_least_cmh2o")
    removed = number(summary, "secretion", "removed_ml")
    percent = number(summary, "secretion", "removed_percent")
    rmse, peak = number(summary, "tip", "rmse_mm"), number(summary, "tip", "peak_error_mm")
    share = "" if percent is None else f"{quantity(percent, '%', 0)} of what was there"
    largest = "".join(_known("largest", peak, "mm", 2))
    vacuum = number(summary, "vacuum", "peak_mmhg")
    set_to = "".join(_known("set to", number(summary, "vacuum", "setpoint_mmhg"), "mmHg", 0))
    return [
        deepest_tip(summary),
        negative_pressure(summary),
        in_airway(summary),
        _without_limit("Highest vacuum", vacuum, "mmHg", 0, set_to),
        _without_limit("Lowest oxygen saturation", number(summary, "spo2_nadir_percent"), "%"),
        _without_limit("Lung volume lost", number(summary, "lung_volume_loss_ml"), "mL", 0),
        _without_limit("Lowest airway pressure", pressure, "cmH2O"),
        _without_limit("Secretions removed", removed, "mL", beside=share),
        carina_force(summary),
        stop_error(summary),
        _without_limit("Tracking error (RMS)", rmse, "mm", 2, largest),
        _without_limit("Whole cycle", number(summary, "timing", "cycle_s"), "s"),
    ]
