"""Ending of a cycle in plain sentences: its kind, its cause, the first sign of a fault.

Bounds for the patient that were broken, in words: as the oracle judged, from the truth alone.
"""

from typing import NamedTuple

from opensuction.report.notice import CONTROLLER, Notice, notices, span
from opensuction.report.wording import amount, quantity, stopped
from opensuction.result.cycle_result import CycleResult, FaultNotice, FaultRecord, TripRecord


class HarmWords(NamedTuple):
    """A broken bound for a person."""

    sentence: str
    """Without its capital and full stop."""
    remedy: str


LOOK = "Look at the patient."

HARMS = {
    "left-inside": HarmWords("the catheter was left in the airway", "Draw it out by the handle."),
    "saturation": HarmWords("oxygen saturation fell below its bound", f"{LOOK} Give oxygen."),
    "airway-pressure": HarmWords(
        "airway pressure was outside its bounds", f"{LOOK} Check circuit, tube and ventilator."
    ),
    "lung-volume": HarmWords(
        "the lungs lost more volume than their bound", f"{LOOK} Recruit as ordered."
    ),
    "tip-past-cap": HarmWords("the tip went deeper than it ever may", f"{LOOK} Look for bleeding."),
    "force": HarmWords(
        "the tip pressed on the carina harder than it may", f"{LOOK} Look for bleeding."
    ),
    "contact-time": HarmWords(
        "the tip pressed on the carina for longer than it may", f"{LOOK} Look for bleeding."
    ),
    "vacuum": HarmWords(
        "vacuum at the tip was above its bound",
        f"{LOOK} Do not suction with this pump until it holds its vacuum.",
    ),
    "advance-under-vacuum": HarmWords("the tip went in under vacuum", f"{LOOK} Look for bleeding."),
    "airway-time": HarmWords("the catheter was in the airway for longer than its bound", LOOK),
    "suction-time": HarmWords("suction lasted longer than its bound", LOOK),
}
"""By the oracle's name, the most urgent for a person first."""


def broken(result: CycleResult) -> list[tuple[str, HarmWords]]:
    """The bounds that were broken, by name, the most urgent first; unknown ones come last."""
    names = result.harms
    known = [(name, words) for name, words in HARMS.items() if name in names]
    unknown = [name for name in names if name not in HARMS]
    return known + [(name, HarmWords(f"the bound '{name}' was broken", LOOK)) for name in unknown]


def sentence(result: CycleResult, name: str, words: HarmWords) -> str:
    """A broken bound with what was measured and the bound itself, where they are known."""
    for bound in result.simulated.broken_bounds if result.simulated else ():
        if bound.name == name and bound.worst is not None and bound.limit is not None:
            worst, limit = (amount(one, bound.unit, 3) for one in (bound.worst, bound.limit))
            return f"{words.sentence} ({worst}, bound {limit})"
    return words.sentence


UNNOTICED = "Nothing noticed it."
ON_REQUEST = "a person asked for it, no safety limit tripped"
TICK_S = 0.0015
"""A trip this near before an abort led to it: the procedure follows the governor by a tick."""
TOGETHER_S = 0.05
"""Drives and power supply speak within this time of what they did."""
ACTED = ("watchdog-fired", "reserve-energy-used")
"""Conditions in which drives or power supply act on their own: what trips later follows from it."""


def event(trip: TripRecord) -> str:
    """A trip in one line: when, and what."""
    return f"{quantity(trip.time_s, 's')}: {trip.sentence}"


def alarm(notice: Notice) -> str:
    """An alarm in one line: how urgent, by whom, when, what, and what to do first."""
    urgent = f"{notice.priority} alarm".strip().capitalize()
    by = "" if notice.by == CONTROLLER else f" by the {raiser(notice)}"
    line = f"{urgent}{by}, {span(notice)}: {stopped(notice.sentence)}"
    if not notice.is_shown:
        line += " The annunciator did not show it."
    return f"{line} {notice.remedy}".strip()


def raiser(notice: Notice) -> str:
    """Source of an alarm, for a person."""
    return {"power": "power supply", "drives": "drives"}.get(notice.by, notice.by)


def aborted_at_s(result: CycleResult) -> float | None:
    """Time at which the abort began; None where the cycle did not abort or it is not known."""
    for phase in result.phases:
        if phase.name == "aborting":
            return phase.start_s
    return None if result.abort is None else result.abort.time_s


def ended(result: CycleResult) -> str:
    """Ending of the cycle, in a word or two."""
    if result.is_completed:
        return "Completed"
    name = result.outcome.capitalize()
    start = aborted_at_s(result)
    return name if start is None else f"{name} at {quantity(start, 's')}"


def reason(result: CycleResult) -> str:
    """First cause of the cycle's early end, not what followed from it."""
    start_s = aborted_at_s(result)
    said = [
        _acted_first(result, start_s),
        _event(result),
        _trip(result, start_s),
        None if result.abort is None else result.abort.sentence,
        # Neither a refused start nor a controller that stopped is a trip or an abort.
        *(fault.noticed.sentence for fault in result.faults if fault.noticed is not None),
    ]
    return next((sentence for sentence in said if sentence is not None), ON_REQUEST)


def _acted_first(result: CycleResult, start_s: float | None) -> str | None:
    """Sentence on drives or power supply that acted before the controller broke the cycle off."""
    for notice in sorted(notices(result), key=lambda notice: notice.started_s or 0.0):
        is_first = start_s is None or (notice.started_s or 0.0) <= start_s
        if notice.condition in ACTED and is_first:
            return notice.sentence
    for sign in (fault.noticed for fault in result.faults):
        if sign is None or sign.by != "drive":
            continue
        if start_s is None or sign.time_s < start_s:
            return sign.sentence
    return None


def _event(result: CycleResult) -> str | None:
    """Reason for which the procedure broke off by itself; None where a trip made it."""
    cause = result.abort
    return None if cause is None or cause.event == "tripped" else cause.sentence


def _trip(result: CycleResult, start_s: float | None) -> str | None:
    """The trip that led to the abort: of those just before it the most urgent, else the first."""
    listed = result.trips
    near = [trip for trip in listed if start_s is not None and abs(trip.time_s - start_s) <= TICK_S]
    order = [notice.condition for notice in notices(result)]

    def place(trip: TripRecord) -> int:
        return order.index(trip.name) if trip.name in order else len(order)

    return next((trip.sentence for trip in [*sorted(near, key=place), *listed]), None)


def injected_fault(result: CycleResult, fault: FaultRecord) -> str:
    """A fault that was injected, and what noticed it first, whoever that was."""
    at_s = fault.at_s
    if at_s is None:
        return f"The fault {fault.name} was to be injected, but its instant never came."
    said = f"Injected fault: {fault.name}"
    if fault.strength is not None:
        unit = "" if fault.strength_unit in (None, "1") else f" {fault.strength_unit}"
        said += f" ({fault.strength:g}{unit})"
    said += f" at {quantity(at_s, 's')}, {fault.meaning}"
    return f"{stopped(said)} {_first_sign(result, fault.noticed, at_s)}"


def _first_sign(result: CycleResult, sign: FaultNotice | None, at_s: float) -> str:
    """First sign of a fault: a detector's, or where none noticed it the first alarm after it."""
    later = [
        (notice.started_s - at_s, notice)
        for notice in notices(result)
        if notice.started_s is not None and notice.started_s >= at_s - TICK_S
    ]
    later.sort(key=lambda pair: pair[0])
    if sign is not None:
        sentence, after_s = sign.sentence, sign.after_s
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


def unnoticed(result: CycleResult) -> list[str]:
    """Names of injected faults that nothing noticed."""
    return [
        fault.name for fault in result.faults if injected_fault(result, fault).endswith(UNNOTICED)
    ]
