"""Account of a cycle in a few plain sentences for a person at the bedside.

No sentence contradicts an alarm, a broken bound or a figure: each figure is described by its own
value.

Sentences on the secretions removed, and on the next pass where little was removed.
"""

from opensuction.procedure.planning.guideline import MOST_PASSES
from opensuction.report import ending, figures, patient_figure
from opensuction.report.figure import CycleFigure, Figure, FigureVerdict, speaking
from opensuction.report.notice import CONTROLLER, notices
from opensuction.report.wording import capitalise, quantity, stopped
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


LEAST_BACKOFF_MM = 0.5
"""A shorter way back is the spring of tip and tissue, no backing off."""
AT_TARGET_MM = 1.0
"""A smaller stopping error needs no side."""


def _yet(result: CycleResult, kind: CycleFigure) -> str:
    """Alarm that contradicts a figure within its limits by the truth; may be empty."""
    if _figure(result, kind).verdict is FigureVerdict.BAD:
        return ""
    against = speaking(result, kind)
    return f" Yet an alarm was raised: {stopped(against[0].sentence)}" if against else ""


def _figure(result: CycleResult, kind: CycleFigure) -> Figure:
    return next(figure for figure in figures.figures(result) if figure.name == kind)


def _injected_faults(result: CycleResult) -> str:
    """Each fault that was injected, and what noticed it."""
    return " ".join(ending.injected_fault(result, entry) for entry in result.faults)


def _broken_bounds(result: CycleResult) -> str:
    """Bounds for the patient that were broken."""
    said = [
        ending.sentence(result, name, words)
        for name, words in ending.broken(result)
        if name != "left-inside"  # the first line says it
    ]
    return stopped(f"Bounds for the patient that were broken: {'; '.join(said)}") if said else ""


def _ending(result: CycleResult) -> str:
    """Time and reason of an early end; empty where the cycle was completed."""
    if result.is_completed:
        return ""
    start = ending.aborted_at_s(result)
    when = "" if start is None else f" after {quantity(start, 's')}"
    return stopped(f"The cycle was aborted{when}: {ending.reason(result)}")


def _check(result: CycleResult) -> str:
    """Result of the pre-use test; empty where it ended the cycle: `_ending` has the reason."""
    if result.check.passed:
        return "The pre-use test of sensors, motor, valve, pump and line was passed."
    said = result.check.sentence
    if said is None or said in _ending(result):
        return ""
    return stopped(f"The pre-use test failed: {said}")


def _preoxygenation(result: CycleResult) -> str:
    """Pre-oxygenation before the cycle, as far as the protocol asks for it."""
    words = {
        "confirmed": "Pre-oxygenation was asked for, and a person confirmed it.",
        "skipped": "Pre-oxygenation was asked for and skipped: [AARC-2022] suggests it.",
        "not-required": "The protocol asks for no pre-oxygenation.",
    }
    return words.get(result.preoxygenation.state, "")


def _teaching(result: CycleResult) -> str:
    """Source of the carina's depth, and its error."""
    known = result.simulated
    if known is None or known.teaching is None:
        return ""
    how = "given" if known.teaching.source == "given" else "taught by hand"
    error = known.teaching.error_mm
    side = "more" if error >= 0.0 else "less"
    return (
        f"The way from the tube's end to the carina was {how}: {quantity(known.taught_mm, 'mm')}, "
        f"{quantity(abs(error), 'mm')} {side} than it is."
    )


def _depth(result: CycleResult) -> str:
    deepest = result.tip.deepest_mm
    if deepest is None:
        return ""
    boundary = result.anatomy.patient_boundary_mm
    tip = "By the controller's estimate the tip" if result.is_recorded else "The catheter tip"
    if boundary is not None and deepest <= boundary < 0.0:
        return f"{tip} did not enter the tube."
    if deepest <= 0.0:
        return f"{tip} did not leave the tube."
    said = f"{tip} went {quantity(deepest, 'mm')} below the end of the tube"
    beyond, cap = figures.past_carina_mm(result), result.anatomy.cap_mm
    if beyond > 0.0:
        said += f", {quantity(beyond, 'mm')} past the carina and into a bronchus"
    if cap is not None and figures.is_search_cap(result):
        said += f"; the search for the carina would have ended at {quantity(cap, 'mm')}"
    elif cap is not None:
        gap = quantity(abs(cap - deepest), "mm")
        side = "short of" if deepest <= cap else "past"
        said += f", {gap} {side} the cap of {quantity(cap, 'mm')} that it must never pass"
    return f"{said}.{_yet(result, CycleFigure.DEEPEST)}"


def _stop(result: CycleResult) -> str:
    error, target = result.tip.stop_error_mm, result.tip.target_mm
    if error is None or target is None:
        return ""
    if figures.is_cut_short(result) and error < 0.0:
        return ""
    tip = "By the controller's estimate the tip" if result.is_recorded else "The tip"
    if abs(error) < AT_TARGET_MM:
        return f"{tip} stopped within {quantity(abs(error), 'mm')} of its target ({target:.1f} mm)."
    side = "short of" if error < 0.0 else "beyond"
    said = f"{tip} stopped {quantity(abs(error), 'mm')} {side} its target ({target:.1f} mm)"
    is_good = figures.stop_error(result).verdict is FigureVerdict.GOOD
    return f"{said}{', within the margin' if is_good else ''}."


def _time_inside(result: CycleResult) -> str:
    """Time of the catheter in the airway, with the reason where it exceeds the guideline's."""
    lasted = result.timing.in_airway_s
    if lasted is None or lasted == 0.0:
        return ""
    said = f"The catheter was in the airway for {quantity(lasted, 's')}"
    if result.is_inside:
        return f"{said} until the record ends, and it is still there."
    guideline = result.timing.in_airway_guideline_s
    if _figure(result, CycleFigure.IN_AIRWAY).is_planned and guideline is not None:
        said += (
            f", over the {guideline:g} s from insertion to removal of [ACI-2014]: by design, for "
            "the tip moves in and out no faster than is gentle, and the time under suction is "
            "what is kept short"
        )
    return f"{said}.{_yet(result, CycleFigure.IN_AIRWAY)}"


def _suction(result: CycleResult) -> str:
    lasted = result.timing.negative_pressure_s
    if lasted is None:
        return ""
    against = _yet(result, CycleFigure.SUCTION)
    if lasted == 0.0:
        return f"There was no suction.{against}"
    guideline = result.timing.guideline_s
    budget = result.timing.negative_pressure_budget_s
    bounds = [("guideline's limit", guideline), ("protocol's limit", budget)]
    if guideline == budget:
        bounds = [("limit of guideline and protocol", guideline)]
    held = []
    for whose, bound in bounds:
        if bound is not None:
            side = "within" if lasted <= bound else "over"
            held.append(f"{side} the {whose} of {bound:g} s")
    if against or "suction-time" in result.harms:
        held = []  # the truth within a limit is no comfort where an alarm says otherwise
    return (
        f"Suction lasted {quantity(lasted, 's')}{': ' if held else ''}{', '.join(held)}.{against}"
    )


def _dwell(result: CycleResult) -> str:
    """That suction where the tip stopped ended early, for nothing came; empty where it did not."""
    lasted, wait = (
        result.timing.dwell_s,
        result.timing.nothing_comes_s,
    )
    if result.timing.dwell_ended_by != "nothing-came":
        return ""
    if lasted is None or wait is None:
        return ""
    return (
        f"Suction at depth ended after {quantity(lasted, 's')}: nothing came for "
        f"{quantity(wait, 's', 2)}."
    )


def _backoff_mm(result: CycleResult) -> float | None:
    """Distance that the tip backed off from the carina; None where it did not or is not known."""
    if not any(phase.name == "backing_off" for phase in result.phases):
        return None
    deepest, reached = result.tip.deepest_mm, result.tip.reached_mm
    return None if deepest is None or reached is None else deepest - reached


def _contact(result: CycleResult) -> str:
    force = result.carina_force_peak_n
    if force is None:
        return _switch(result)
    if force == 0.0:
        return f"The tip did not touch the carina.{_yet(result, CycleFigure.FORCE)}"
    said = f"The tip touched the carina with at most {quantity(force, 'N', 2)}"
    backoff = _backoff_mm(result)
    if backoff is not None and backoff >= LEAST_BACKOFF_MM:
        said += f" and backed off by {quantity(backoff, 'mm')} before suction"
    return f"{said}."


def _switch(result: CycleResult) -> str:
    """State of the contact switch at the tip, where the force is not known."""
    if result.recorded is None:
        return ""
    closed_s, met_mm = result.recorded.contact
    if met_mm is not None:
        return f"The contact switch closed, and the tip backed off from {quantity(met_mm, 'mm')}."
    if closed_s == 0.0:
        return "The contact switch at the tip did not close."
    return f"The contact switch at the tip was closed for {quantity(closed_s, 's', 2)}."


def _unknown(result: CycleResult) -> str:
    """Unknown values of a cycle that a machine recorded; empty where the truth is known."""
    if not result.is_recorded:
        return ""
    rest = [
        words
        for value, words in (
            (result.carina_force_peak_n, "the force on the carina"),
            (result.secretion.removed_ml, "how much was removed"),
        )
        if value is None
    ]
    listed = ", ".join(["where the tip really was", *rest])
    return (
        f"Not known from the recording: {listed}, how much volume the lungs lost, and whether a "
        "bound for the patient was broken: only a twin can tell."
    )


def _raised(result: CycleResult) -> str:
    """Trips and number of alarms, with the source of alarms that were not the controller's."""
    listed = notices(result)
    names = {notice.condition for notice in listed}
    silent = [f"Safety limit: {trip.sentence}" for trip in result.trips if trip.name not in names]
    if not silent and not listed:
        return "No safety limit tripped and no alarm was raised."
    said = silent
    if len(listed) == 1:
        said.append("One alarm was raised")
    elif listed:
        said.append(f"{len(listed)} alarms were raised")
    others = dict.fromkeys(ending.raiser(one) for one in listed if one.by != CONTROLLER)
    if others:
        said[-1] += f", by the {' and the '.join(others)} too"
    if listed and all(one.by != CONTROLLER for one in listed):
        said[-1] = said[-1].removesuffix(" too") + ", not by the controller"
    if any(not one.is_shown for one in listed):
        said.append("Not all of them were shown at the bedside")
    return stopped(". ".join(said))


PARTS = (
    _injected_faults,
    _broken_bounds,
    _ending,
    patient_figure.heart_and_blood,
    patient_figure.lungs,
    removed,
    next_pass,
    _time_inside,
    _suction,
    _dwell,
    _depth,
    _contact,
    _stop,
    _raised,
    _check,
    _preoxygenation,
    _teaching,
    _unknown,
)
"""In the order of the page: what matters to the patient first, what came before the cycle last."""


def sentences(result: CycleResult) -> list[str]:
    """Events of the cycle, most important first; what is not known is left out."""
    return [capitalise(sentence) for part in PARTS if (sentence := part(result))]
