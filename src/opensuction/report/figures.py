"""Key figures of a cycle, each beside its limit and with a verdict in words."""

from opensuction.report import patient_figure
from opensuction.report.figure import (
    CycleFigure,
    Figure,
    FigureVerdict,
    add,
    against,
    hear,
    known,
    without_limit,
)
from opensuction.report.wording import depth_words, quantity
from opensuction.result.cycle_result import CycleResult

PAST_CARINA_MM = 1.0
"""Tissue and tip give way by less; what is deeper has gone into a bronchus [design]."""
ESTIMATED = "by the controller's estimate"
"""Beside a depth of the tip for which there is no truth."""
CLEARANCE_PERCENT = 50.0
"""Less than half removed, and the purpose of the cycle was not met [design]."""


def at_end(result: CycleResult) -> Figure:
    """Place of the tip when the record ends."""
    end_mm = result.tip.end_mm
    if end_mm is None:
        return Figure(CycleFigure.AT_END, quantity(None, "mm"), "", FigureVerdict.ABSENT, "")
    tip = f"tip {depth_words(end_mm)}"
    if result.is_recorded:
        tip = add(tip, ESTIMATED)
    if result.is_inside:
        return Figure(CycleFigure.AT_END, "inside", tip, FigureVerdict.BAD, "still in the airway")
    return Figure(CycleFigure.AT_END, "out", tip, FigureVerdict.GOOD, "out of the airway")


def is_search_cap(result: CycleResult) -> bool:
    """True if the cap only ends a search for the carina, and lies beyond it."""
    cap, carina = result.anatomy.cap_mm, result.anatomy.carina_mm
    by_contact = result.approach == "contact"
    if by_contact and carina is None and result.is_recorded:
        return cap is not None  # no machine knows where the carina is: it feels for it
    return by_contact and cap is not None and carina is not None and cap > carina


def is_cut_short(result: CycleResult) -> bool:
    """True if the cycle was broken off before there was any suction."""
    no_suction = result.timing.negative_pressure_s == 0.0
    return no_suction and not result.is_completed


def past_carina_mm(result: CycleResult) -> float:
    """Depth of the tip past the carina; 0 where it was not past it, or the carina is not known."""
    deepest, carina = result.tip.deepest_mm, result.anatomy.carina_mm
    if deepest is None or carina is None or deepest <= carina + PAST_CARINA_MM:
        return 0.0
    return deepest - carina


def deepest_tip(result: CycleResult) -> Figure:
    """Deepest position of the tip against its cap and the carina."""
    deepest, cap = result.tip.deepest_mm, result.anatomy.cap_mm
    limit = "" if cap is None else f"cap {quantity(cap, 'mm')} below the tube's end"
    verdict, remark = against(deepest, cap, "cap")
    carina = result.anatomy.carina_mm
    if is_search_cap(result) and carina is None:
        limit = f"the search for the carina ends at {quantity(cap, 'mm')}"
        if verdict is FigureVerdict.GOOD:
            remark = "within the search"
    elif is_search_cap(result):
        limit = f"carina {quantity(carina, 'mm')}; the search for it ends at {quantity(cap, 'mm')}"
        if verdict is FigureVerdict.GOOD:
            remark = "not past the carina"
    beyond = past_carina_mm(result)
    if beyond > 0.0:
        verdict, remark = FigureVerdict.BAD, f"{quantity(beyond, 'mm')} past the carina"
    if result.is_recorded:
        possible = known("at most", result.tip.deepest_possible_mm, "mm")
        limit = add(limit, ", ".join([ESTIMATED, *possible]))
    return Figure(CycleFigure.DEEPEST, quantity(deepest, "mm"), limit, verdict, remark)


def stop_error(result: CycleResult) -> Figure:
    """Stopping point of the tip against the target.

    Tolerance is the margin to the cap; where the carina was to be touched and left again, the
    distance by which it was to be left.
    """
    error = result.tip.stop_error_mm
    target, cap = result.tip.target_mm, result.anatomy.cap_mm
    limit = "" if target is None else f"target {quantity(target, 'mm')}"
    if result.is_recorded:
        limit = add(limit, ESTIMATED)
    if error is None or target is None or cap is None:
        return without_limit(CycleFigure.STOP, error, "mm", beside=limit, signed=True)
    tolerance, whose = cap - target, "cap"
    carina = result.anatomy.carina_mm
    if result.approach == "contact" and carina is not None and carina > target:
        tolerance, whose = carina - target, "carina"
    limit += f", margin to the {whose} {quantity(tolerance, 'mm')}"
    verdict, remark = FigureVerdict.GOOD, "at the target"
    if error < -tolerance and is_cut_short(result):
        verdict, remark = FigureVerdict.NEUTRAL, "broken off before it was reached"
    elif error < -tolerance:
        verdict, remark = FigureVerdict.NOTICE, "short of the target"
    elif error > tolerance:
        verdict, remark = FigureVerdict.BAD, "beyond the target"
    return Figure(CycleFigure.STOP, quantity(error, "mm", signed=True), limit, verdict, remark)


def negative_pressure(result: CycleResult) -> Figure:
    """Duration of suction against the protocol's budget and the guideline's limit."""
    lasted = result.timing.negative_pressure_s
    budget = result.timing.negative_pressure_budget_s
    guideline = result.timing.guideline_s
    verdict, remark = against(lasted, budget, "protocol's limit")
    beyond = lasted is not None and guideline is not None and lasted > guideline
    if beyond and verdict is not FigureVerdict.BAD:
        verdict, remark = FigureVerdict.NOTICE, "over the guideline"
    if lasted == 0.0:
        done = result.is_completed
        verdict = FigureVerdict.NOTICE if done else FigureVerdict.NEUTRAL
        remark = "there was no suction"
    limits = [*known("limit", budget, "s"), *known("guideline", guideline, "s")]
    return Figure(CycleFigure.SUCTION, quantity(lasted, "s"), ", ".join(limits), verdict, remark)


def in_airway(result: CycleResult) -> Figure:
    """Time of the catheter in the airway, against the protocol and the guideline for hands."""
    lasted = result.timing.in_airway_s
    budget = result.timing.in_airway_budget_s
    guideline = result.timing.in_airway_guideline_s
    verdict, remark = against(lasted, budget, "limit")
    limits = [*known("limit", budget, "s"), *known("ACI-2014", guideline, "s", 0)]
    planned = False
    if result.is_inside:
        verdict, remark = FigureVerdict.BAD, "and it is still there"
    elif verdict is FigureVerdict.GOOD and lasted is not None and guideline is not None:
        planned = lasted > guideline
        if planned:
            verdict, remark = FigureVerdict.NOTICE, "over ACI-2014 by design, within the limit"
    value = quantity(lasted, "s")
    return Figure(CycleFigure.IN_AIRWAY, value, ", ".join(limits), verdict, remark, planned)


def vacuum(result: CycleResult) -> Figure:
    """Highest vacuum at the tip in the airway against the guideline; else the line's."""
    line, tip = result.vacuum.peak_mmhg, result.vacuum.tip_peak_mmhg
    guideline = result.vacuum.guideline_mmhg
    setpoint = known("set to", result.vacuum.setpoint_mmhg, "mmHg", 0)
    limit = result.vacuum.limit_mmhg
    if result.is_recorded and limit is not None:
        words = ["in the line", *known("limit", limit, "mmHg", 0), *setpoint]
        verdict, remark = against(line, limit, "limit")
        return Figure(
            CycleFigure.VACUUM,
            quantity(line, "mmHg", 0),
            ", ".join(words),
            verdict,
            remark,
        )
    if tip is None or guideline is None:
        return without_limit(CycleFigure.VACUUM, line, "mmHg", 0, "".join(setpoint))
    beside = ["at the tip", *known("guideline", guideline, "mmHg", 0)]
    beside += [*known("in the line", line, "mmHg", 0), *setpoint]
    verdict, remark = FigureVerdict.GOOD, "within the guideline"
    if tip > guideline:
        verdict, remark = FigureVerdict.BAD, "over the guideline"
    elif line is not None and line > guideline:
        verdict, remark = FigureVerdict.NOTICE, "the line was over the guideline"
    elif tip == 0.0:
        verdict, remark = FigureVerdict.NEUTRAL, "none in the airway"
    value = quantity(tip, "mmHg", 0)
    return Figure(CycleFigure.VACUUM, value, ", ".join(beside), verdict, remark)


def removed(result: CycleResult) -> Figure:
    """Volume of secretions removed, against the volume that was there."""
    found = result.secretion.removed_ml
    percent = result.secretion.removed_percent
    if found is None or percent is None:
        return without_limit(CycleFigure.REMOVED, found, "mL")
    share = f"{quantity(percent, '%', 0)} of what was there"
    verdict, remark = FigureVerdict.GOOD, "at least half"
    if is_cut_short(result) and percent < CLEARANCE_PERCENT:
        verdict, remark = FigureVerdict.NEUTRAL, "broken off before suction"
    elif percent < CLEARANCE_PERCENT:
        verdict, remark = FigureVerdict.NOTICE, "less than half"
    return Figure(CycleFigure.REMOVED, quantity(found, "mL"), share, verdict, remark)


def carina_force(result: CycleResult) -> Figure:
    """Highest force on the carina."""
    force = result.carina_force_peak_n
    verdict, remark = FigureVerdict.NEUTRAL, "contact, as wanted"
    if force is None:
        verdict, remark = FigureVerdict.ABSENT, ""
    elif force == 0.0:
        verdict, remark = FigureVerdict.GOOD, "no contact"
    elif result.approach == "travel":
        verdict, remark = FigureVerdict.NOTICE, "contact, and none was wanted"
    return Figure(CycleFigure.FORCE, quantity(force, "N", 2), "", verdict, remark)


def figures(result: CycleResult) -> list[Figure]:
    """Key figures, what matters most to the patient first; none denies an alarm."""
    rmse, peak = result.tip.rmse_mm, result.tip.peak_error_mm
    largest = "".join(known("largest", peak, "mm", 2))
    listed = [
        at_end(result),
        patient_figure.saturation(result),
        patient_figure.heart_rate(result),
        patient_figure.airway_pressure(result),
        patient_figure.lung_volume(result),
        removed(result),
        in_airway(result),
        negative_pressure(result),
        vacuum(result),
        deepest_tip(result),
        carina_force(result),
        stop_error(result),
        without_limit(CycleFigure.TRACKING, rmse, "mm", 2, largest),
        without_limit(CycleFigure.RESTED, result.timing.cycle_s, "s"),
    ]
    return [hear(result, figure) for figure in listed]
