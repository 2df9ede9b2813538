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


def deepest_tip(summary: Summary) -> Figure:
    """Deepest position of the tip against its cap."""
    deepest, cap = number(summary, "tip", "deepest_mm"), number(summary, "anatomy", "cap_mm")
    verdict, remark = _against(deepest, cap, "cap")
    limit = "" if cap is None else f"cap {quantity(cap, 'mm')} below the tube's end"
    return Figure("Deepest tip position", quantity(deepest, "mm"), limit, verdict, remark)


def stop_error(summary: Summary) -> Figure:
    """Where the tip stopped against the target.

    Tolerance is the margin to the cap; where the carina was to be touched and left again, the
    distance by which it was to be left.
    """
    error = number(summary, "tip", "stop_error_mm")
    target, cap = number(summary, "tip", "target_mm"), number(summary, "anatomy", "cap_mm")
    name, shown = "Stopping error", quantity(error, "mm", signed=True)
    limit = "" if target is None else f"target {quantity(target, 'mm')}"
    if error is None:
        return Figure(name, shown, limit, FigureVerdict.ABSENT, "")
    if target is None or cap is None:
        return Figure(name, shown, limit, FigureVerdict.NEUTRAL, "")
    tolerance, whose = cap - target, "cap"
    carina = number(summary, "anatomy", "carina_mm")
    if text(summary, "approach") == "contact" and carina is not None and carina > target:
        tolerance, whose = carina - target, "carina"
    limit += f", margin to the {whose} {quantity(tolerance, 'mm')}"
    if error < -tolerance:
        return Figure(name, shown, limit, FigureVerdict.NOTICE, "short of the target")
    if error > tolerance:
        return Figure(name, shown, limit, FigureVerdict.BAD, "beyond the target")
    return Figure(name, shown, limit, FigureVerdict.GOOD, "at the target")


def negative_pressure(summary: Summary) -> Figure:
    """How long suction lasted against the protocol's budget and the guideline's limit."""
    lasted = number(summary, "timing", "negative_pressure_s")
    budget = number(summary, "timing", "negative_pressure_budget_s")
    guideline = number(summary, "timing", "guideline_s")
    verdict, remark = _against(lasted, budget, "protocol's limit")
    beyond = lasted is not None and guideline is not None and lasted > guideline
    if beyond and verdict is not FigureVerdict.BAD:
        verdict, remark = FigureVerdict.NOTICE, "over the guideline"
    limits = [] if budget is None else [f"limit {quantity(budget, 's')}"]
    limits += [] if guideline is None else [f"guideline {quantity(guideline, 's')}"]
    return Figure(
        "Time under negative pressure", quantity(lasted, "s"), ", ".join(limits), verdict, remark
    )


def in_airway(summary: Summary) -> Figure:
    """How long the catheter was in the airway."""
    lasted = number(summary, "timing", "in_airway_s")
    budget = number(summary, "timing", "in_airway_budget_s")
    verdict, remark = _against(lasted, budget, "limit")
    limit = "" if budget is None else f"limit {quantity(budget, 's')}"
    return Figure("Time in the airway", quantity(lasted, "s"), limit, verdict, remark)


def peak_vacuum(summary: Summary) -> Figure:
    """Highest vacuum in the line against its set point and limit."""
    peak = number(summary, "vacuum", "peak_mmhg")
    setpoint, bound = (number(summary, "vacuum", key) for key in ("setpoint_mmhg", "limit_mmhg"))
    verdict, remark = _against(peak, bound, "limit")
    limits = [] if setpoint is None else [f"set to {quantity(setpoint, 'mmHg', 0)}"]
    limits += [] if bound is None else [f"limit {quantity(bound, 'mmHg', 0)}"]
    return Figure("Highest vacuum", quantity(peak, "mmHg", 0), ", ".join(limits), verdict, remark)


def secretion(summary: Summary) -> Figure:
    """Secretions taken out."""
    removed = number(summary, "secretion", "removed_ml")
    percent = number(summary, "secretion", "removed_percent")
    limit = "" if percent is None else f"{quantity(percent, '%', 0)} of what was there"
    verdict = FigureVerdict.ABSENT if removed is None else FigureVerdict.NEUTRAL
    return Figure("Secretions removed", quantity(removed, "mL"), limit, verdict, "")


def carina_force(summary: Summary) -> Figure:
    """Highest force on the carina."""
    force = number(summary, "carina_force_peak_n")
    name, shown = "Force on the carina", quantity(force, "N", 2)
    if force is None:
        return Figure(name, shown, "", FigureVerdict.ABSENT, "")
    bound = number(summary, "carina_force_limit_n")
    limit = "" if bound is None else f"limit {quantity(bound, 'N', 2)}"
    if force == 0.0:
        return Figure(name, shown, limit, FigureVerdict.GOOD, "no contact")
    if text(summary, "approach") == "travel":
        return Figure(name, shown, limit, FigureVerdict.NOTICE, "contact, and none was wanted")
    verdict, remark = _against(force, bound, "limit")
    return Figure(name, shown, limit, verdict, remark or "contact, as wanted")


def tracking(summary: Summary) -> Figure:
    """How closely the tip followed the desired position."""
    rmse, peak = number(summary, "tip", "rmse_mm"), number(summary, "tip", "peak_error_mm")
    limit = "" if peak is None else f"largest {quantity(peak, 'mm', 2)}"
    verdict = FigureVerdict.ABSENT if rmse is None else FigureVerdict.NEUTRAL
    return Figure("Tracking error (RMS)", quantity(rmse, "mm", 2), limit, verdict, "")


DECIMALS = {"s": 1, "%": 1, "cmH2O": 1, "mL": 0}
"""Decimals of the figures that have no limit, by unit."""


def _without_limit(summary: Summary, name: str, unit: str, *path: str) -> Figure:
    value = number(summary, *path)
    verdict = FigureVerdict.ABSENT if value is None else FigureVerdict.NEUTRAL
    return Figure(name, quantity(value, unit, DECIMALS[unit]), "", verdict, "")


def figures(summary: Summary) -> list[Figure]:
    """Key figures, what matters most to the patient first."""
    return [
        deepest_tip(summary),
        negative_pressure(summary),
        in_airway(summary),
        peak_vacuum(summary),
        _without_limit(summary, "Lowest oxygen saturation", "%", "spo2_nadir_percent"),
        _without_limit(summary, "Lung volume lost", "mL", "lung_volume_loss_ml"),
        _without_limit(summary, "Lowest airway pressure", "cmH2O", "airway_pressure_least_cmh2o"),
        secretion(summary),
        carina_force(summary),
        stop_error(summary),
        tracking(summary),
        _without_limit(summary, "Whole cycle", "s", "timing", "cycle_s"),
    ]
