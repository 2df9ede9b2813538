"""Account of a cycle in a few plain sentences for a person at the bedside.

No sentence contradicts an alarm, a broken bound or a figure: each figure is described by its own
value.
"""

from opensuction.report import (
    clearance_words,
    contradicting_alarms,
    ending,
    figures,
    harm,
    patient_words,
)
from opensuction.report.figure import Figure, FigureVerdict
from opensuction.report.notice import CONTROLLER, notices
from opensuction.report.summary import (
    Summary,
    harms,
    is_completed,
    is_inside,
    is_recorded,
    number,
    rows,
    text,
    value,
)
from opensuction.report.wording import capitalise, quantity, stopped

LEAST_BACKOFF_MM = 0.5
"""A shorter way back is the spring of tip and tissue, no backing off."""
AT_TARGET_MM = 1.0
"""A smaller stopping error needs no side."""


def _yet(summary: Summary, name: str) -> str:
    """What an alarm says against a figure that is within its limits by the truth; may be empty."""
    if _figure(summary, name).verdict is FigureVerdict.BAD:
        return ""
    against = contradicting_alarms.speaking(summary, name)
    return f" Yet an alarm was raised: {stopped(against[0].sentence)}" if against else ""


def _figure(summary: Summary, name: str) -> Figure:
    return next(figure for figure in figures.figures(summary) if figure.name == name)


def _injected_faults(summary: Summary) -> str:
    """Each fault that was injected, and what noticed it."""
    return " ".join(ending.injected_fault(summary, entry) for entry in rows(summary, "faults"))


def _broken_bounds(summary: Summary) -> str:
    """Bounds for the patient that were broken."""
    said = [
        harm.sentence(summary, name, words)
        for name, words in harm.broken(summary)
        if name != "left-inside"  # the first line says it
    ]
    return stopped(f"Bounds for the patient that were broken: {'; '.join(said)}") if said else ""


def _ending(summary: Summary) -> str:
    """Why and when the cycle ended before its time; empty where it was completed."""
    if is_completed(summary):
        return ""
    start = ending.aborted_at_s(summary)
    when = "" if start is None else f" after {quantity(start, 's')}"
    return stopped(f"The cycle was aborted{when}: {ending.reason(summary)}")


def _check(summary: Summary) -> str:
    """How the pre-use test ended; empty where it ended the cycle: `_ending` has the reason."""
    passed = value(summary, "check", "passed")
    if passed is True:
        return "The pre-use test of sensors, motor, valve, pump and line was passed."
    said = text(summary, "check", "sentence")
    if said is None or said in _ending(summary):
        return ""
    return stopped(f"The pre-use test failed: {said}")


def _preoxygenation(summary: Summary) -> str:
    """Whether oxygen was given before, as far as the protocol asks for it."""
    words = {
        "confirmed": "Pre-oxygenation was asked for, and a person confirmed it.",
        "skipped": "Pre-oxygenation was asked for and skipped: [AARC-2022] suggests it.",
        "not-required": "The protocol asks for no pre-oxygenation.",
    }
    return words.get(text(summary, "preoxygenation", "state") or "", "")


def _teaching(summary: Summary) -> str:
    """Where the depth of the carina came from, and how far it was off."""
    taught = number(summary, "taught_mm")
    if taught is None:
        return ""
    how = "given" if text(summary, "teaching", "source") == "given" else "taught by hand"
    said = f"The way from the tube's end to the carina was {how}: {quantity(taught, 'mm')}"
    error = number(summary, "teaching", "error_mm")
    if error is not None:
        side = "more" if error >= 0.0 else "less"
        said += f", {quantity(abs(error), 'mm')} {side} than it is"
    return f"{said}."


def _depth(summary: Summary) -> str:
    deepest = number(summary, "tip", "deepest_mm")
    if deepest is None:
        return ""
    boundary = number(summary, "anatomy", "patient_boundary_mm")
    tip = "By the controller's estimate the tip" if is_recorded(summary) else "The catheter tip"
    if boundary is not None and deepest <= boundary < 0.0:
        return f"{tip} did not enter the tube."
    if deepest <= 0.0:
        return f"{tip} did not leave the tube."
    said = f"{tip} went {quantity(deepest, 'mm')} below the end of the tube"
    beyond, cap = figures.past_carina_mm(summary), number(summary, "anatomy", "cap_mm")
    if beyond > 0.0:
        said += f", {quantity(beyond, 'mm')} past the carina and into a bronchus"
    if cap is not None and figures.is_search_cap(summary):
        said += f"; the search for the carina would have ended at {quantity(cap, 'mm')}"
    elif cap is not None:
        gap = quantity(abs(cap - deepest), "mm")
        side = "short of" if deepest <= cap else "past"
        said += f", {gap} {side} the cap of {quantity(cap, 'mm')} that it must never pass"
    return f"{said}.{_yet(summary, contradicting_alarms.DEEPEST)}"


def _stop(summary: Summary) -> str:
    error, target = number(summary, "tip", "stop_error_mm"), number(summary, "tip", "target_mm")
    if error is None or target is None:
        return ""
    if figures.is_cut_short(summary) and error < 0.0:
        return ""
    tip = "By the controller's estimate the tip" if is_recorded(summary) else "The tip"
    if abs(error) < AT_TARGET_MM:
        return f"{tip} stopped within {quantity(abs(error), 'mm')} of its target ({target:.1f} mm)."
    side = "short of" if error < 0.0 else "beyond"
    said = f"{tip} stopped {quantity(abs(error), 'mm')} {side} its target ({target:.1f} mm)"
    is_good = figures.stop_error(summary).verdict is FigureVerdict.GOOD
    return f"{said}{', within the margin' if is_good else ''}."


def _time_inside(summary: Summary) -> str:
    """How long the catheter was in the airway, and why that is more than a hand may take."""
    lasted = number(summary, "timing", "in_airway_s")
    if lasted is None or lasted == 0.0:
        return ""
    said = f"The catheter was in the airway for {quantity(lasted, 's')}"
    if is_inside(summary):
        return f"{said} until the record ends, and it is still there."
    guideline = number(summary, "timing", "in_airway_guideline_s")
    if _figure(summary, contradicting_alarms.IN_AIRWAY).is_planned and guideline is not None:
        said += (
            f", over the {guideline:g} s from insertion to removal of [ACI-2014]: by design, for "
            "the tip moves in and out no faster than is gentle, and the time under suction is "
            "what is kept short"
        )
    return f"{said}.{_yet(summary, contradicting_alarms.IN_AIRWAY)}"


def _suction(summary: Summary) -> str:
    lasted = number(summary, "timing", "negative_pressure_s")
    if lasted is None:
        return ""
    against = _yet(summary, contradicting_alarms.SUCTION)
    if lasted == 0.0:
        return f"There was no suction.{against}"
    guideline = number(summary, "timing", "guideline_s")
    budget = number(summary, "timing", "negative_pressure_budget_s")
    bounds = [("guideline's limit", guideline), ("protocol's limit", budget)]
    if guideline == budget:
        bounds = [("limit of guideline and protocol", guideline)]
    held = []
    for whose, bound in bounds:
        if bound is not None:
            side = "within" if lasted <= bound else "over"
            held.append(f"{side} the {whose} of {bound:g} s")
    if against or "suction-time" in harms(summary):
        held = []  # the truth within a limit is no comfort where an alarm says otherwise
    return (
        f"Suction lasted {quantity(lasted, 's')}{': ' if held else ''}{', '.join(held)}.{against}"
    )


def _dwell(summary: Summary) -> str:
    """That suction where the tip stopped ended early, for nothing came; empty where it did not."""
    lasted, wait = (
        number(summary, "timing", "dwell_s"),
        number(summary, "timing", "nothing_comes_s"),
    )
    if text(summary, "timing", "dwell_ended_by") != "nothing-came":
        return ""
    if lasted is None or wait is None:
        return ""
    return (
        f"Suction at depth ended after {quantity(lasted, 's')}: nothing came for "
        f"{quantity(wait, 's', 2)}."
    )


def _backoff_mm(summary: Summary) -> float | None:
    """How far the tip left the carina before suction; None where it did not or is not known."""
    if not any(phase.get("name") == "backing_off" for phase in rows(summary, "phases")):
        return None
    deepest, reached = number(summary, "tip", "deepest_mm"), number(summary, "tip", "reached_mm")
    return None if deepest is None or reached is None else deepest - reached


def _contact(summary: Summary) -> str:
    force = number(summary, "carina_force_peak_n")
    if force is None:
        return _switch(summary)
    if force == 0.0:
        return f"The tip did not touch the carina.{_yet(summary, contradicting_alarms.FORCE)}"
    said = f"The tip touched the carina with at most {quantity(force, 'N', 2)}"
    backoff = _backoff_mm(summary)
    if backoff is not None and backoff >= LEAST_BACKOFF_MM:
        said += f" and backed off by {quantity(backoff, 'mm')} before suction"
    return f"{said}."


def _switch(summary: Summary) -> str:
    """What the contact switch at the tip said, where the force is not known."""
    closed_s = number(summary, "contact", "closed_s")
    if closed_s is None:
        return ""
    met_mm = number(summary, "contact", "touched_mm")
    if met_mm is not None:
        return f"The contact switch closed, and the tip backed off from {quantity(met_mm, 'mm')}."
    if closed_s == 0.0:
        return "The contact switch at the tip did not close."
    return f"The contact switch at the tip was closed for {quantity(closed_s, 's', 2)}."


def _unknown(summary: Summary) -> str:
    """What nobody can say of a cycle that a machine recorded; empty where the truth is known."""
    if not is_recorded(summary):
        return ""
    rest = [
        words
        for key, words in (
            ("carina_force_peak_n", "the force on the carina"),
            ("secretion", "how much was removed"),
        )
        if number(summary, key) is None and number(summary, key, "removed_ml") is None
    ]
    listed = ", ".join(["where the tip really was", *rest])
    return (
        f"Not known from the recording: {listed}, how much volume the lungs lost, and whether a "
        "bound for the patient was broken: only a twin can tell."
    )


def _raised(summary: Summary) -> str:
    """What tripped and alarmed, in numbers, and who alarmed where it was not the controller."""
    listed = notices(summary)
    names = {notice.condition for notice in listed}
    silent = [
        f"Safety limit: {text(trip, 'sentence') or text(trip, 'name')}"
        for trip in rows(summary, "trips")
        if (text(trip, "name") or "").replace("_", "-") not in names
    ]
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
    patient_words.heart_and_blood,
    patient_words.lungs,
    clearance_words.removed,
    clearance_words.next_pass,
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


def sentences(summary: Summary) -> list[str]:
    """What happened, most important first; what is not known is left out."""
    return [capitalise(sentence) for part in PARTS if (sentence := part(summary))]
