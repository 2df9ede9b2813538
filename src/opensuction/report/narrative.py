"""What happened in a cycle, in a few plain sentences for a person at the bedside."""

from opensuction.report import figures
from opensuction.report.figures import FigureVerdict
from opensuction.report.summary import Summary, is_completed, is_inside, number, rows, text, value
from opensuction.report.wording import capitalise, quantity

ON_REQUEST = "a person asked for it, no safety limit tripped"


LEAST_BACKOFF_MM = 0.5
"""A shorter way back is the spring of tip and tissue, no backing off."""


def _with_stop(sentence: str) -> str:
    """A sentence as it was written elsewhere, made to end with exactly one full stop."""
    return sentence.rstrip(". ") + "."


def event(entry: Summary) -> str:
    """A trip in one line: when, and what."""
    time_s = number(entry, "time_s")
    said = text(entry, "sentence") or text(entry, "name") or "?"
    when = "" if time_s is None else f"{quantity(time_s, 's')}: "
    return f"{when}{said}"


def alarm_span(entry: Summary) -> str:
    """From when to when an alarm was shown."""
    started_s, ended_s = number(entry, "started_s"), number(entry, "ended_s")
    begin = "?" if started_s is None else quantity(started_s, "s")
    return f"from {begin} on" if ended_s is None else f"{begin} to {quantity(ended_s, 's')}"


def alarm(entry: Summary) -> str:
    """An alarm in one line: how urgent, when, what, and what to do first."""
    said = text(entry, "sentence") or text(entry, "condition") or "?"
    priority = text(entry, "priority")
    urgent = "Alarm" if priority is None else f"{priority.capitalize()} alarm"
    remedy = text(entry, "remedy")
    line = f"{urgent}, {alarm_span(entry)}: {_with_stop(said)}"
    return line if remedy is None else f"{line} {remedy}"


def aborted_at_s(summary: Summary) -> float | None:
    """When the abort began; None where the cycle did not abort or the time is not known."""
    for phase in rows(summary, "phases"):
        if phase.get("name") == "aborting":
            return number(phase, "start_s")
    return number(summary, "abort", "time_s")


def outcome(summary: Summary) -> str:
    """What a person must know first: ``Completed``, ``Aborted at 17.0 s``, or that it is inside."""
    if not is_inside(summary):
        return _ended(summary)
    end_mm = number(summary, "tip", "end_mm") or 0.0
    where = f"{quantity(abs(end_mm), 'mm')} {'below' if end_mm >= 0.0 else 'above'} the tube's end"
    return f"CATHETER IS STILL IN THE AIRWAY, {where}: draw it out by the handle"


def _ended(summary: Summary) -> str:
    """How the cycle ended, in a word or two."""
    if is_completed(summary):
        return "Completed"
    name = (text(summary, "outcome") or "unknown outcome").capitalize()
    start = aborted_at_s(summary)
    return name if start is None else f"{name} at {quantity(start, 's')}"


def lead(summary: Summary) -> str:
    """The one line under the outcome: why it ended early, or which figures need a look."""
    names = [f.name.lower() for f in figures.figures(summary) if f.verdict in figures.ATTENTION]
    look = f"Look at: {', '.join(names)}." if names else ""
    if is_inside(summary):
        reason = "" if is_completed(summary) else _with_stop(capitalise(_reason(summary)))
        return f"{_with_stop(_ended(summary))} {reason} {look}".replace("  ", " ").strip()
    if is_completed(summary):
        return look or "Every figure that has a limit is within it."
    reason = _reason(summary)
    return f"{_with_stop(capitalise(reason))} {look}".strip()


def _reason(summary: Summary) -> str:
    """Why the cycle ended before its time: the first trip, or what else broke it off."""
    for entry in rows(summary, "trips"):
        return text(entry, "sentence") or text(entry, "name") or ON_REQUEST
    said = [text(summary, "abort", "sentence")]
    # Neither a refused start nor a controller that stopped is a trip or an abort.
    said += [text(entry, "noticed", "sentence") for entry in rows(summary, "faults")]
    return next((sentence for sentence in said if sentence is not None), ON_REQUEST)


def _ending(summary: Summary) -> str:
    """Why and when the cycle ended before its time; empty where it was completed."""
    if is_completed(summary):
        return ""
    start = aborted_at_s(summary)
    when = "" if start is None else f" after {quantity(start, 's')}"
    return _with_stop(f"The cycle was aborted{when}: {_reason(summary)}")


def _check(summary: Summary) -> str:
    """How the pre-use test ended; empty where it ended the cycle: `_ending` has the reason."""
    passed = value(summary, "check", "passed")
    if passed is True:
        return "The pre-use test of sensors, motor, valve, pump and line was passed."
    said = text(summary, "check", "sentence")
    if said is None or said in _ending(summary):
        return ""
    return _with_stop(f"The pre-use test failed: {said}")


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
    if boundary is not None and deepest <= boundary < 0.0:
        return "The catheter tip did not enter the tube."
    if deepest <= 0.0:
        return "The catheter tip did not leave the tube."
    said = f"The catheter tip went {quantity(deepest, 'mm')} below the end of the tube"
    cap = number(summary, "anatomy", "cap_mm")
    if cap is not None:
        gap = quantity(abs(cap - deepest), "mm")
        side = "short of" if deepest <= cap else "past"
        said += f", {gap} {side} the cap of {quantity(cap, 'mm')} that it must never pass"
    return f"{said}."


def _stop(summary: Summary) -> str:
    error, target = number(summary, "tip", "stop_error_mm"), number(summary, "tip", "target_mm")
    if error is None or target is None:
        return ""
    if figures.stop_error(summary).verdict is FigureVerdict.GOOD:
        return f"It stopped within {quantity(abs(error), 'mm')} of its target ({target:.1f} mm)."
    side = "short of" if error < 0 else "beyond"
    return f"It stopped {quantity(abs(error), 'mm')} {side} its target ({target:.1f} mm)."


def _suction(summary: Summary) -> str:
    lasted = number(summary, "timing", "negative_pressure_s")
    if lasted is None:
        return ""
    if lasted == 0.0:
        return "There was no suction."
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
    return f"Suction lasted {quantity(lasted, 's')}{': ' if held else ''}{', '.join(held)}."


def _secretion(summary: Summary) -> str:
    removed = number(summary, "secretion", "removed_ml")
    if removed is None:
        return ""
    percent = number(summary, "secretion", "removed_percent")
    share = "" if percent is None else f", {quantity(percent, '%', 0)} of what was there"
    return f"It removed {quantity(removed, 'mL')} of secretions{share}."


def _patient(summary: Summary) -> str:
    """What suction did to the patient's breathing, as far as there is a patient."""
    saturation = number(summary, "spo2_nadir_percent")
    loss = number(summary, "lung_volume_loss_ml")
    pressure = number(summary, "airway_pressure_least_cmh2o")
    said = []
    if saturation is not None:
        said.append(f"oxygen saturation was {quantity(saturation, '%')} at its lowest")
    if loss is not None:
        said.append(f"the lungs lost up to {quantity(loss, 'mL', 0)} of their resting volume")
    if pressure is not None:
        below = ", below the air outside" if pressure < 0.0 else ""
        said.append(f"the lowest airway pressure was {quantity(pressure, 'cmH2O')}{below}")
    return _with_stop(capitalise("; ".join(said))) if said else ""


def _backoff_mm(summary: Summary) -> float | None:
    """How far the tip left the carina before suction; None where it did not or is not known."""
    if not any(phase.get("name") == "backing_off" for phase in rows(summary, "phases")):
        return None
    deepest, reached = number(summary, "tip", "deepest_mm"), number(summary, "tip", "reached_mm")
    return None if deepest is None or reached is None else deepest - reached


def _contact(summary: Summary) -> str:
    force = number(summary, "carina_force_peak_n")
    if force is None:
        return ""
    if force == 0.0:
        return "The tip did not touch the carina."
    said = f"The tip touched the carina with at most {quantity(force, 'N', 2)}"
    backoff = _backoff_mm(summary)
    if backoff is not None and backoff >= LEAST_BACKOFF_MM:
        said += f" and backed off by {quantity(backoff, 'mm')} before suction"
    return f"{said}."


def _faults(summary: Summary) -> str:
    """What tripped and alarmed beyond the reason that the ending already gave."""
    trips, alarms = rows(summary, "trips"), rows(summary, "alarms")
    if not trips and not alarms:
        return "No safety limit tripped and no alarm was raised."
    others = trips if is_completed(summary) else trips[1:]
    said = [f"Safety limit: {text(trip, 'sentence') or text(trip, 'name')}" for trip in others]
    if len(alarms) == 1:
        said.append("One alarm was raised")
    elif alarms:
        said.append(f"{len(alarms)} alarms were raised")
    return _with_stop(". ".join(said)) if said else ""


def _injected_faults(summary: Summary) -> str:
    """Each fault that was injected, and what noticed it."""
    return " ".join(_with_stop(_injected_fault(entry)) for entry in rows(summary, "faults"))


def _injected_fault(entry: Summary) -> str:
    at_s, name = number(entry, "at_s"), text(entry, "name") or "?"
    if at_s is None:
        return f"The fault {name} was to be injected, but its instant never came"
    strength, unit = number(entry, "strength"), text(entry, "strength_unit")
    said = f"Injected fault: {name}"
    if strength is not None:
        said += f" ({strength:g}{'' if unit in (None, '1') else f' {unit}'})"
    said += f" at {quantity(at_s, 's')}"
    meaning = text(entry, "meaning")
    if meaning is not None:
        said += f", {meaning}"
    sentence, after_s = text(entry, "noticed", "sentence"), number(entry, "noticed", "after_s")
    if sentence is None or after_s is None:
        return f"{said}. Nothing noticed it"
    return f"{said}. It was noticed {quantity(after_s, 's', 3)} later: {sentence}"


def sentences(summary: Summary) -> list[str]:
    """What happened, most important first; what is not known is left out."""
    parts = (
        _injected_faults,
        _ending,
        _check,
        _teaching,
        _depth,
        _contact,
        _stop,
        _suction,
        _secretion,
        _patient,
        _faults,
    )
    return [sentence for part in parts if (sentence := part(summary))]
