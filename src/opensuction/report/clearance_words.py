"""Sentences on the secretions removed, and on the next pass where little was removed."""

from opensuction.procedure.planning.pass_rule import MOST_PASSES
from opensuction.report import figures
from opensuction.report.notice import notices
from opensuction.report.wording import quantity
from opensuction.result.cycle_result import CycleResult

LEAST_REMOVED_ML = 0.05
"""Less rounds to nothing."""
DRAWING = (
    "vacuum-lost",
    "line-clogged",
    "line-leaking",
    "canister-full",
    "valve-stuck-closed",
)
"""Conditions for which little is removed because nothing is drawn."""


def removed(result: CycleResult) -> str:
    """Volume of secretions removed, in a sentence; empty where it is not known."""
    volume_ml = result.secretion.removed_ml
    if volume_ml is None:
        return ""
    if result.timing.negative_pressure_s == 0.0 and volume_ml < LEAST_REMOVED_ML:
        return "No secretions were removed."
    percent = result.secretion.removed_percent
    share = "" if percent is None else f", {quantity(percent, '%', 0)} of what was there"
    return f"Suction removed {quantity(volume_ml, 'mL')} of secretions{share}."


def next_pass(result: CycleResult) -> str:
    """Advice on a next pass where less than half was removed; empty where there is none."""
    percent = result.secretion.removed_percent
    if percent is None or percent >= figures.CLEARANCE_PERCENT or not result.is_completed:
        return ""
    if result.is_inside or result.harms:
        return ""
    raised = {notice.condition for notice in notices(result)}
    if "pass-limit-reached" in raised:
        return "No further pass: the permitted number is reached, and a person assesses."
    volume_ml = result.secretion.removed_ml or 0.0
    if volume_ml < LEAST_REMOVED_ML or raised.intersection(DRAWING):
        return (
            "Hardly anything was drawn: look for a clog or a leak from the tip to the pump before "
            "another pass."
        )
    if any(notice.priority == "high" for notice in notices(result)):
        return "Less than half was removed; the alarm comes before another pass."
    return (
        "Less than half was removed: the next pass may follow after the patient's rest, "
        f"{MOST_PASSES} in all at most; then a person assesses."
    )
