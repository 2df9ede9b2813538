"""The safety case on paper: its HTML page, with a strip chart of each hazard's worst run."""

import math

from opensuction import __version__
from opensuction.evidence.safety_case.hazard import STATE_WORDS, Hazard, Response
from opensuction.evidence.safety_case.hazard_result import HazardResult
from opensuction.evidence.safety_case.safety_case import HazardVerdict, SafetyCase
from opensuction.report.sheet import Curve, Level, Plot, Section, Sheet, Table
from opensuction.safety.condition import Condition
from opensuction.twin.fault.fault_table import ROWS

LEAD = (
    "Every fault is put into the digital twin at its instant; alarm and safe state are timed "
    "against bounds that were argued beforehand. In-silico: no hardware, no patient."
)
METHOD = (
    "A run counts as alarmed when one of the conditions that the row expects is signalled, and as "
    "safe from the instant after which the safe state holds to the end of the run, by the truth "
    "of the twin. In every run the force at the tip stays within 0.3 N, the tip above its cap and "
    "the vacuum within 200 mmHg for an adult, or the row is broken.",
    "Times are those of the run that broke a bound, or came nearest to one. A dash means that "
    "it did not happen, or was not needed: some rows accept a whole cycle within every limit.",
)


def _time(value: float) -> float | None:
    return round(value) if math.isfinite(value) else None


def _name(alarm: str) -> str:
    return alarm.lower().replace("_", " ") or "-"


def _overview(verdict: HazardVerdict) -> tuple[object, ...]:
    worst, row = verdict.worst, verdict.hazard.row
    claim = worst.case.claim
    alarm = _name(worst.alarm)
    if claim.response == Response.REFUSAL:
        alarm = "refused before the start"
    elif worst.ok and not worst.answered:
        alarm = "not needed: within every limit"
    return (
        row.id,
        row.hazard,
        alarm,
        worst.priority,
        _time(worst.detected_ms),
        int(claim.detected_ms),
        claim.safe_state,
        _time(worst.safe_ms),
        int(claim.safe_ms),
        f"{sum(not result.ok for result in verdict.results)} of {len(verdict.results)}",
        verdict.ok,
    )


def _marks(result: HazardResult) -> tuple[Level, ...]:
    marks = [Level(result.at_s, "fault")]
    for name, after_ms in (("alarm", result.detected_ms), ("safe", result.safe_ms)):
        if math.isfinite(after_ms):
            marks.append(Level(result.at_s + after_ms / 1000.0, name))
    return tuple(marks)


def _plots(result: HazardResult) -> tuple[Plot, ...]:
    strip = result.strip
    if strip is None:
        return ()
    time_s = strip.time_s.astype(float)

    def curve(label: str, name: str, hue: str, factor: float = 1.0) -> Curve:
        return Curve(label, factor * getattr(strip, name).astype(float), hue)

    marks = _marks(result)
    head = (curve("Tip", "tip_mm", "tip"), curve("Catheter head", "head_mm", "head"))
    line = (
        curve("Line vacuum (mmHg)", "vacuum_mmhg", "line-vacuum"),
        curve("Valve open (%)", "valve_percent", "valve"),
    )
    answer = (
        curve("Governor: 2 hold, 3 withdraw, 4 torque off", "reaction", "reference"),
        curve("Alarm: 1 low, 2 medium, 3 high", "priority", "contact"),
    )
    return (
        Plot("Catheter", "Time (s)", "mm below the tube", head, time_s, marks=marks),
        Plot("Suction", "Time (s)", "mmHg, %", line, time_s, marks=marks),
        Plot("Answer", "Time (s)", "Level", answer, time_s, marks=marks),
    )


def _runs(verdict: HazardVerdict) -> Table:
    """Every fault of a hazard: its worst run over strengths, phases and seeds."""
    groups: dict[tuple[str, str], list[HazardResult]] = {}
    for result in verdict.results:
        case = result.case
        phase = "before the start" if case.phase is None else case.phase.name.lower()
        groups.setdefault((case.claim.name, phase), []).append(result)
    rows = []
    for (fault, phase), results in groups.items():
        worst = HazardVerdict(verdict.hazard, tuple(results)).worst
        strengths = sorted({result.case.strength for result in results})
        known = ROWS[worst.case.claim.fault].strength
        unit = "" if known is None or known.unit == "1" else f" {known.unit}"
        shown = "" if known is None else ", ".join(f"{one:g}" for one in strengths) + unit
        rows.append(
            (
                fault,
                phase,
                shown,
                len(results),
                _name(worst.alarm),
                _time(worst.detected_ms),
                int(worst.case.claim.detected_ms),
                _time(worst.safe_ms),
                int(worst.case.claim.safe_ms),
                worst.problem or "within bounds",
                all(result.ok for result in results),
            )
        )
    columns = ("fault", "comes in", "strengths", "runs", "alarm", "ms", "bound", "safe, ms")
    return Table("Faults; of each the worst run", (*columns, "bound", "finding", "ok"), tuple(rows))


def _because(one: Hazard) -> tuple[str, ...]:
    return tuple(dict.fromkeys(claim.because for claim in one.claims))


def _section(verdict: HazardVerdict) -> Section:
    row, worst = verdict.hazard.row, verdict.worst
    claim = worst.case.claim
    text = [
        f"Cause: {row.cause}. Effect: {row.effect} ({row.severity.value}).",
        f"Detection: {row.detection}. Control: {row.control}.",
        f"Safe state: {STATE_WORDS[claim.safe_state]}.",
        "Why these bounds: " + " ".join(_because(verdict.hazard)),
    ]
    if worst.alarm:
        said = Condition[worst.alarm].row
        text.append(f"What a person reads: {said.sentence}. {said.remedy}")
    text.append(f"Requirements: {', '.join(row.requirements)}. Worst run: {worst.case.title}.")
    title = f"{row.id} {row.hazard}{'' if verdict.ok else ': broken'}"
    return Section(title, tuple(text), (_runs(verdict),), _plots(worst))


def sheet(found: SafetyCase) -> Sheet:
    """The page of a safety case."""
    held = sum(verdict.ok for verdict in found.verdicts)
    runs = sum(len(verdict.results) for verdict in found.verdicts)
    overview = Table(
        "Each hazard by its worst run",
        (
            "id",
            "hazard",
            "alarm",
            "priority",
            "alarm, ms",
            "bound",
            "safe state",
            "safe, ms",
            "bound",
            "broken",
            "ok",
        ),
        tuple(_overview(verdict) for verdict in found.verdicts),
    )
    return Sheet(
        title="Safety case",
        verdict=f"{held} of {len(found.verdicts)} hazards answered within their bounds",
        good=found.ok,
        lead=LEAD,
        run=(
            ("version", __version__),
            ("runs", str(runs)),
            ("seeds", ", ".join(str(seed) for seed in found.seeds)),
        ),
        sections=(
            Section("Overview", METHOD, (overview,)),
            *(_section(verdict) for verdict in found.verdicts),
        ),
    )
