"""Key figures of a cycle, each beside its limit and with a verdict in words."""

from opensuction.report import contradicting_alarms, patient_figure
from opensuction.report.figure import (
    Figure,
    FigureVerdict,
    add,
    against,
    known,
    without_limit,
)
from opensuction.report.summary import (
    Summary,
    is_completed,
    is_inside,
    is_recorded,
    number,
    text,
)
from opensuction.report.wording import depth_words, quantity

PAST_CARINA_MM = 1.0
"""Tissue and tip give way by less; what is deeper has gone into a bronchus [design]."""
ESTIMATED = "by the controller's estimate"
"""Beside a depth of the tip for which there is no truth."""
CLEARANCE_PERCENT = 50.0
"""Less than half removed, and the purpose of the cycle was not met [design]."""


def at_end(summary: Summary) -> Figure:
    """Where the tip is when the record ends."""
    end_mm = number(summary, "tip", "end_mm")
    if end_mm is None:
        return Figure(
            contradicting_alarms.AT_END, quantity(None, "mm"), "", FigureVerdict.ABSENT, ""
        )
    tip = f"tip {depth_words(end_mm)}"
    if is_recorded(summary):
        tip = add(tip, ESTIMATED)
    if is_inside(summary):
        return Figure(
            contradicting_alarms.AT_END, "inside", tip, FigureVerdict.BAD, "still in the airway"
        )
    return Figure(contradicting_alarms.AT_END, "out", tip, FigureVerdict.GOOD, "out of the airway")


def is_search_cap(summary: Summary) -> bool:
    """Whether the cap only ends a search for the carina, and lies beyond it."""
    cap, carina = number(summary, "anatomy", "cap_mm"), number(summary, "anatomy", "carina_mm")
    by_contact = text(summary, "approach") == "contact"
    if by_contact and carina is None and is_recorded(summary):
        return cap is not None  # no machine knows where the carina is: it feels for it
    return by_contact and cap is not None and carina is not None and cap > carina


def is_cut_short(summary: Summary) -> bool:
    """Whether the cycle was broken off before there was any suction."""
    no_suction = number(summary, "timing", "negative_pressure_s") == 0.0
    return no_suction and not is_completed(summary)


def past_carina_mm(summary: Summary) -> float:
    """How far the tip went into a bronchus; 0 where it did not, or the carina is not known."""
    deepest, carina = number(summary, "tip", "deepest_mm"), number(summary, "anatomy", "carina_mm")
    if deepest is None or carina is None or deepest <= carina + PAST_CARINA_MM:
        return 0.0
    return deepest - carina


def deepest_tip(summary: Summary) -> Figure:
    """Deepest position of the tip against its cap and the carina."""
    deepest, cap = number(summary, "tip", "deepest_mm"), number(summary, "anatomy", "cap_mm")
    limit = "" if cap is None else f"cap {quantity(cap, 'mm')} below the tube's end"
    verdict, remark = against(deepest, cap, "cap")
    carina = number(summary, "anatomy", "carina_mm")
    if is_search_cap(summary) and carina is None:
        limit = f"the search for the carina ends at {quantity(cap, 'mm')}"
        if verdict is FigureVerdict.GOOD:
            remark = "within the search"
    elif is_search_cap(summary):
        limit = f"carina {quantity(carina, 'mm')}; the search for it ends at {quantity(cap, 'mm')}"
        if verdict is FigureVerdict.GOOD:
            remark = "not past the carina"
    beyond = past_carina_mm(summary)
    if beyond > 0.0:
        verdict, remark = FigureVerdict.BAD, f"{quantity(beyond, 'mm')} past the carina"
    if is_recorded(summary):
        possible = known("at most", number(summary, "tip", "deepest_possible_mm"), "mm")
        limit = add(limit, ", ".join([ESTIMATED, *possible]))
    return Figure(contradicting_alarms.DEEPEST, quantity(deepest, "mm"), limit, verdict, remark)


def stop_error(summary: Summary) -> Figure:
    """Where the tip stopped against the target.

    Tolerance is the margin to the cap; where the carina was to be touched and left again, the
    distance by which it was to be left.
    """
    error = number(summary, "tip", "stop_error_mm")
    target, cap = number(summary, "tip", "target_mm"), number(summary, "anatomy", "cap_mm")
    limit = "" if target is None else f"target {quantity(target, 'mm')}"
    if is_recorded(summary):
        limit = add(limit, ESTIMATED)
    if error is None or target is None or cap is None:
        return without_limit(contradicting_alarms.STOP, error, "mm", beside=limit, signed=True)
    tolerance, whose = cap - target, "cap"
    carina = number(summary, "anatomy", "carina_mm")
    if text(summary, "approach") == "contact" and carina is not None and carina > target:
        tolerance, whose = carina - target, "carina"
    limit += f", margin to the {whose} {quantity(tolerance, 'mm')}"
    verdict, remark = FigureVerdict.GOOD, "at the target"
    if error < -tolerance and is_cut_short(summary):
        verdict, remark = FigureVerdict.NEUTRAL, "broken off before it was reached"
    elif error < -tolerance:
        verdict, remark = FigureVerdict.NOTICE, "short of the target"
    elif error > tolerance:
        verdict, remark = FigureVerdict.BAD, "beyond the target"
    return Figure(
        contradicting_alarms.STOP, quantity(error, "mm", signed=True), limit, verdict, remark
    )


def negative_pressure(summary: Summary) -> Figure:
    """How long suction lasted against the protocol's budget and the guideline's limit."""
    lasted = number(summary, "timing", "negative_pressure_s")
    budget = number(summary, "timing", "negative_pressure_budget_s")
    guideline = number(summary, "timing", "guideline_s")
    verdict, remark = against(lasted, budget, "protocol's limit")
    beyond = lasted is not None and guideline is not None and lasted > guideline
    if beyond and verdict is not FigureVerdict.BAD:
        verdict, remark = FigureVerdict.NOTICE, "over the guideline"
    if lasted == 0.0:
        done = is_completed(summary)
        verdict = FigureVerdict.NOTICE if done else FigureVerdict.NEUTRAL
        remark = "there was no suction"
    limits = [*known("limit", budget, "s"), *known("guideline", guideline, "s")]
    return Figure(
        contradicting_alarms.SUCTION, quantity(lasted, "s"), ", ".join(limits), verdict, remark
    )


def in_airway(summary: Summary) -> Figure:
    """How long the catheter was in the airway, against the protocol and the guideline for hands."""
    lasted = number(summary, "timing", "in_airway_s")
    budget = number(summary, "timing", "in_airway_budget_s")
    guideline = number(summary, "timing", "in_airway_guideline_s")
    verdict, remark = against(lasted, budget, "limit")
    limits = [*known("limit", budget, "s"), *known("ACI-2014", guideline, "s", 0)]
    planned = False
    if is_inside(summary):
        verdict, remark = FigureVerdict.BAD, "and it is still there"
    elif verdict is FigureVerdict.GOOD and lasted is not None and guideline is not None:
        planned = lasted > guideline
        if planned:
            verdict, remark = FigureVerdict.NOTICE, "over ACI-2014 by design, within the limit"
    value = quantity(lasted, "s")
    return Figure(
        contradicting_alarms.IN_AIRWAY, value, ", ".join(limits), verdict, remark, planned
    )


def vacuum(summary: Summary) -> Figure:
    """Highest vacuum at the tip in the airway against the guideline; else the line's."""
    line, tip = number(summary, "vacuum", "peak_mmhg"), number(summary, "vacuum", "tip_peak_mmhg")
    guideline = number(summary, "vacuum", "guideline_mmhg")
    setpoint = known("set to", number(summary, "vacuum", "setpoint_mmhg"), "mmHg", 0)
    limit = number(summary, "vacuum", "limit_mmhg")
    if is_recorded(summary) and limit is not None:
        words = ["in the line", *known("limit", limit, "mmHg", 0), *setpoint]
        verdict, remark = against(line, limit, "limit")
        return Figure(
            contradicting_alarms.VACUUM,
            quantity(line, "mmHg", 0),
            ", ".join(words),
            verdict,
            remark,
        )
    if tip is None or guideline is None:
        return without_limit(contradicting_alarms.VACUUM, line, "mmHg", 0, "".join(setpoint))
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
    return Figure(contradicting_alarms.VACUUM, value, ", ".join(beside), verdict, remark)


def removed(summary: Summary) -> Figure:
    """How much was removed of what was there."""
    found = number(summary, "secretion", "removed_ml")
    percent = number(summary, "secretion", "removed_percent")
    if found is None or percent is None:
        return without_limit(contradicting_alarms.REMOVED, found, "mL")
    share = f"{quantity(percent, '%', 0)} of what was there"
    verdict, remark = FigureVerdict.GOOD, "at least half"
    if is_cut_short(summary) and percent < CLEARANCE_PERCENT:
        verdict, remark = FigureVerdict.NEUTRAL, "broken off before suction"
    elif percent < CLEARANCE_PERCENT:
        verdict, remark = FigureVerdict.NOTICE, "less than half"
    return Figure(contradicting_alarms.REMOVED, quantity(found, "mL"), share, verdict, remark)


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
    return Figure(contradicting_alarms.FORCE, quantity(force, "N", 2), "", verdict, remark)


def figures(summary: Summary) -> list[Figure]:
    """Key figures, what matters most to the patient first; none denies an alarm."""
    rmse, peak = number(summary, "tip", "rmse_mm"), number(summary, "tip", "peak_error_mm")
    largest = "".join(known("largest", peak, "mm", 2))
    listed = [
        at_end(summary),
        patient_figure.saturation(summary),
        patient_figure.heart_rate(summary),
        patient_figure.airway_pressure(summary),
        patient_figure.lung_volume(summary),
        removed(summary),
        in_airway(summary),
        negative_pressure(summary),
        vacuum(summary),
        deepest_tip(summary),
        carina_force(summary),
        stop_error(summary),
        without_limit("Tracking error (RMS)", rmse, "mm", 2, largest),
        without_limit("Until the machine rested", number(summary, "timing", "cycle_s"), "s"),
    ]
    return [contradicting_alarms.hear(summary, figure) for figure in listed]
