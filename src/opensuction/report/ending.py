"""Ending of a cycle in plain sentences: its kind, its cause, the first sign of a fault."""

from opensuction.report.notice import CONTROLLER, Notice, notices, span
from opensuction.report.summary import Summary, is_completed, number, rows, text
from opensuction.report.wording import quantity, stopped

UNNOTICED = "Nothing noticed it."
ON_REQUEST = "a person asked for it, no safety limit tripped"
TICK_S = 0.0015
"""A trip this near before an abort led to it: the procedure follows the governor by a tick."""
TOGETHER_S = 0.05
"""Drives and power supply speak within this time of what they did."""
ACTED = ("watchdog-fired", "reserve-energy-used")
"""Conditions in which drives or power supply act on their own: what trips later follows from it."""


def event(entry: Summary) -> str:
    """A trip in one line: when, and what."""
    time_s = number(entry, "time_s")
    said = text(entry, "sentence") or text(entry, "name") or "?"
    when = "" if time_s is None else f"{quantity(time_s, 's')}: "
    return f"{when}{said}"


def alarm(notice: Notice) -> str:
    """An alarm in one line: how urgent, by whom, when, what, and what to do first."""
    urgent = f"{notice.priority} alarm".strip().capitalize()
    by = "" if notice.by == CONTROLLER else f" by the {raiser(notice)}"
    line = f"{urgent}{by}, {span(notice)}: {stopped(notice.sentence)}"
    if not notice.is_shown:
        line += " The annunciator did not show it."
    return f"{line} {notice.remedy}".strip()


def raiser(notice: Notice) -> str:
    """Who raised an alarm, for a person."""
    return {"power": "power supply", "drives": "drives"}.get(notice.by, notice.by)


def aborted_at_s(summary: Summary) -> float | None:
    """When the abort began; None where the cycle did not abort or the time is not known."""
    for phase in rows(summary, "phases"):
        if phase.get("name") == "aborting":
            return number(phase, "start_s")
    return number(summary, "abort", "time_s")


def ended(summary: Summary) -> str:
    """How the cycle ended, in a word or two."""
    if is_completed(summary):
        return "Completed"
    name = (text(summary, "outcome") or "unknown outcome").capitalize()
    start = aborted_at_s(summary)
    return name if start is None else f"{name} at {quantity(start, 's')}"


def reason(summary: Summary) -> str:
    """Why the cycle ended before its time: what came first, not what followed from it."""
    start_s = aborted_at_s(summary)
    said = [
        _acted_first(summary, start_s),
        _event(summary),
        _trip(summary, start_s),
        text(summary, "abort", "sentence"),
        # Neither a refused start nor a controller that stopped is a trip or an abort.
        *(text(entry, "noticed", "sentence") for entry in rows(summary, "faults")),
    ]
    return next((sentence for sentence in said if sentence is not None), ON_REQUEST)


def _acted_first(summary: Summary, start_s: float | None) -> str | None:
    """What made drives or power supply act before the controller broke the cycle off."""
    for notice in sorted(notices(summary), key=lambda notice: notice.started_s or 0.0):
        is_first = start_s is None or (notice.started_s or 0.0) <= start_s
        if notice.condition in ACTED and is_first:
            return notice.sentence
    for entry in rows(summary, "faults"):
        time_s = number(entry, "noticed", "time_s")
        is_first = start_s is None or (time_s is not None and time_s < start_s)
        if text(entry, "noticed", "by") == "drive" and is_first:
            return text(entry, "noticed", "sentence")
    return None


def _event(summary: Summary) -> str | None:
    """Why the procedure broke off by itself; None where a trip made it."""
    event_name = text(summary, "abort", "event")
    return None if event_name in (None, "tripped") else text(summary, "abort", "sentence")


def _trip(summary: Summary, start_s: float | None) -> str | None:
    """The trip that led to the abort: of those just before it the most urgent, else the first."""
    listed = rows(summary, "trips")
    near = [
        trip
        for trip in listed
        if start_s is not None and abs((number(trip, "time_s") or 0.0) - start_s) <= TICK_S
    ]
    order = [notice.condition for notice in notices(summary)]

    def place(trip: Summary) -> int:
        name = (text(trip, "name") or "").replace("_", "-")
        return order.index(name) if name in order else len(order)

    for trip in [*sorted(near, key=place), *listed]:
        return text(trip, "sentence") or text(trip, "name")
    return None


def injected_fault(summary: Summary, entry: Summary) -> str:
    """A fault that was injected, and what noticed it first, whoever that was."""
    at_s, name = number(entry, "at_s"), text(entry, "name") or "?"
    if at_s is None:
        return f"The fault {name} was to be injected, but its instant never came."
    strength, unit = number(entry, "strength"), text(entry, "strength_unit")
    said = f"Injected fault: {name}"
    if strength is not None:
        said += f" ({strength:g}{'' if unit in (None, '1') else f' {unit}'})"
    said += f" at {quantity(at_s, 's')}"
    meaning = text(entry, "meaning")
    if meaning is not None:
        said += f", {meaning}"
    return f"{stopped(said)} {_first_sign(summary, entry, at_s)}"


def _first_sign(summary: Summary, entry: Summary, at_s: float) -> str:
    """What noticed a fault first: a detector, or where none did the first alarm after it."""
    sentence, after_s = text(entry, "noticed", "sentence"), number(entry, "noticed", "after_s")
    later = [
        (notice.started_s - at_s, notice)
        for notice in notices(summary)
        if notice.started_s is not None and notice.started_s >= at_s - TICK_S
    ]
    later.sort(key=lambda pair: pair[0])
    if sentence is not None and after_s is not None:
        # Drives and power supply speak for themselves; the detector only saw them act.
        for delay_s, notice in later:
            if notice.by != CONTROLLER and delay_s <= after_s + TOGETHER_S:
                sentence, after_s = notice.sentence, max(delay_s, 0.0)
        return stopped(f"It was noticed {quantity(after_s, 's', 3)} later: {sentence}")
    if later:
        delay_s, notice = later[0]
        return stopped(
            f"No detector of the machine named it; the first alarm came "
            f"{quantity(max(delay_s, 0.0), 's')} later: {notice.sentence}"
        )
    return UNNOTICED


def unnoticed(summary: Summary) -> list[str]:
    """Names of injected faults that nothing noticed."""
    return [
        text(entry, "name") or "?"
        for entry in rows(summary, "faults")
        if injected_fault(summary, entry).endswith(UNNOTICED)
    ]
