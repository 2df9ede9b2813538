"""A safety case as a page, with a strip chart of each hazard's worst run."""

from collections.abc import Sequence

from opensuction.report.sheet import Cell, Curve, Level, Plot, Section, Sheet, Table
from opensuction.result.cycle_result import LeftInsideCount
from opensuction.result.safety_case_result import (
    DaySearchResult,
    FaultSummary,
    HarmSearchResult,
    HarmSearchRun,
    HazardDetail,
    HazardSummary,
    SafetyCaseResult,
    Series,
)

LEAD = (
    "Every fault is put into the digital twin at its instant; alarm and safe state are timed "
    "against bounds that were argued beforehand. In-silico: no hardware, no patient."
)
METHOD = (
    "A run counts as alarmed when people at the bedside are told of one of the conditions that the "
    "row expects: by the annunciator, whoever raised it. It is safe from the instant after which "
    "the safe state holds to the end of the run, by the truth of the twin. A catheter that stays "
    "inside is no safe state; it counts on its own.",
    "What the patient bore is judged by age from the truth alone, summed over the whole run, which "
    "is watched for a minute after the machine has come to rest. Bounds of time are for an adult; "
    "a child has two thirds of them.",
    "Then each hazard is searched for harm: instants from .1 s before to .1 s after each phase "
    "begins, strengths from the least to the most, two machines of each patient and approach; the "
    "first runs are spread over all of it, the others are near what was worst. The share says how "
    "much of the way from the same cycle without a fault to the nearest bound the worst run went; "
    "what the fault makes unavoidable is added to the bound.",
    "Last, days of 30 cycles, one each half hour, without a fault: machine and patient up to three "
    "standard deviations from the nominal ones, who cough, breathe and are moved, by both "
    "approaches, with and without self-calibration; here the share is the worst value over its "
    "bound.",
    "Times are those of the run that broke a bound, or came nearest to one. A dash means that "
    "it did not happen, or was not needed: some rows accept a whole cycle within every limit.",
)


def page(found: SafetyCaseResult, details: Sequence[HazardDetail]) -> Sheet:
    """The page. details: of each of its hazards."""
    held = sum(hazard.ok for hazard in found.hazards)
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
            "left inside",
            "broken",
            "searched",
            "ok",
        ),
        tuple(_overview(detail) for detail in details),
    )
    return Sheet(
        title="Safety case",
        verdict=f"{held} of {len(found.hazards)} hazards answered within their bounds",
        good=found.ok,
        lead=LEAD,
        run=(
            ("version", found.version),
            ("runs", str(found.runs)),
            ("seeds", ", ".join(str(seed) for seed in found.seeds)),
            ("left inside", _left_inside(found.left_inside)),
        ),
        sections=(
            Section("Overview", (), (overview, *_stayed(found.hazards))),
            *_days(found.days),
            Section("How it was judged", METHOD),
            Section("Worst run of each hazard"),
            *(_section(detail) for detail in details),
        ),
    )


def _left_inside(found: LeftInsideCount) -> str:
    """Runs that ended with the tip inside, in words."""
    if not found.count:
        return "in no run"
    return (
        f"in {found.count} runs, {found.unavoidable} of them unavoidable; "
        f"{found.told} told high in time"
    )


def _stayed(hazards: Sequence[HazardSummary]) -> tuple[Table, ...]:
    """Hazards in which a catheter stayed inside: why, and what a person must do."""
    rows = tuple(
        (
            Cell(hazard.id, href=f"#{hazard.id}"),
            hazard.left_inside.count,
            hazard.left_inside.unavoidable,
            hazard.left_inside.told,
            "; ".join(hazard.unavoidable) or "nothing makes it so",
            " ".join(hazard.person),
        )
        for hazard in hazards
        if hazard.left_inside.count
    )
    if not rows:
        return ()
    columns = ("id", "runs", "unavoidable", "told high", "unavoidable because", "a person must")
    return (Table("Left inside at the end of the run", columns, rows),)


def _times(worst: HazardSummary | FaultSummary) -> tuple[int | None, ...]:
    """Alarm and safe state of the worst run, each with its bound, in whole ms."""
    times = (worst.detected_ms, worst.detected_bound_ms, worst.safe_ms, worst.safe_bound_ms)
    return tuple(None if time is None else round(time) for time in times)


def _name(alarm: str | None) -> str:
    return "-" if alarm is None else alarm.replace("_", " ")


def _overview(detail: HazardDetail) -> tuple[object, ...]:
    hazard = detail.summary
    alarm = _name(hazard.alarm)
    if detail.refusal:
        alarm = "refused before the start"
    elif hazard.within_limits:
        alarm = "not needed: within every limit"
    detected, detected_bound, safe, safe_bound = _times(hazard)
    left = hazard.left_inside
    return (
        Cell(hazard.id, href=f"#{hazard.id}"),
        hazard.hazard,
        alarm,
        hazard.priority,
        detected,
        detected_bound,
        hazard.safe_state,
        safe,
        safe_bound,
        f"{left.count} ({left.unavoidable} unavoidable)" if left.count else "-",
        f"{hazard.broken} of {hazard.runs}",
        describe_search(hazard.searched),
        hazard.ok,
    )


def describe_search(found: HarmSearchResult) -> str:
    """Number of searched runs that broke a bound, or the nearest approach to one."""
    if found.broken:
        return f"{found.broken} of {found.runs} broken"
    worst = found.worst
    if worst is None:
        return "-"
    slow = f", {len(found.unavoidable)} too slow" if found.unavoidable else ""
    if worst.share is None:
        return f"beyond {worst.bound}{slow}"
    share = 100.0 * max(worst.share, 0.0)
    nearest = f"{share:.0f} % to {worst.bound}" if share >= 0.5 else "nothing borne"
    return f"{nearest}{slow}"


def describe_days(found: DaySearchResult) -> str:
    """Result of the days in a sentence."""
    many = f"{found.days} days without a fault, {found.cycles} cycles"
    broken = f"a bound broken in {found.broken}, untold in {found.untold}"
    if not found.broken and found.worst is not None and found.worst.share is not None:
        broken = (
            f"no bound broken, nearest {found.worst.bound} at {100.0 * found.worst.share:.0f} %"
        )
    refused = f" ({found.refused} more could not be planned)" if found.refused else ""
    return f"{many}{refused}, {found.aborted} broken off: {broken}."


def _days(found: DaySearchResult) -> tuple[Section, ...]:
    """Days without a fault: those that broke a bound, or the one that came nearest to one."""
    if found.worst is None:
        return ()
    columns = ("day", "cycles", "broken off", "bound", "worst", "limit", "unit", "cycle", "told")
    rows = tuple(
        (
            day.command,
            day.cycles,
            day.aborted,
            day.bound,
            day.worst,
            day.limit,
            day.unit,
            day.cycle,
            day.told if found.problems else None,
        )
        for day in found.problems or (found.worst,)
    )
    title = "Days in which a bound was broken" if found.problems else "The nearest to a bound"
    return (
        Section("Days without a fault", (describe_days(found),), (Table(title, columns, rows),)),
    )


def _value(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _worst_searched(runs: int, worst: HarmSearchRun) -> str:
    """The worst run of a search in a sentence. runs: of the search."""
    at = "" if worst.after_s is None else f"@{worst.after_s:g}"
    strength = "" if worst.strength is None else f"={worst.strength:.3g}"
    end = f"broke {', '.join(worst.broken)}" if worst.broken else "broke none"
    told = "people were told" if worst.told else "nobody was told"
    return (
        f"Worst of {runs} searched runs: {worst.fault}{at}{strength}, "
        f"{worst.patient} by {worst.approach}, seed {worst.seed}: {worst.bound} "
        f"{_value(worst.worst)} {worst.unit} of {_value(worst.limit)}; it {end}, and {told}."
    )


def _section(detail: HazardDetail) -> Section:
    hazard = detail.summary
    text = [
        f"Cause: {detail.cause}. Effect: {detail.effect} ({hazard.severity}).",
        f"Detection: {detail.detection}. Control: {detail.control}.",
        f"Safe state: {detail.safe_state}.",
        "Why these bounds: " + " ".join(detail.because),
    ]
    if detail.sentence:
        text.append(f"What a person reads: {detail.sentence}")
    requirements = ", ".join(hazard.requirements)
    text.append(f"Requirements: {requirements}. Worst run: {hazard.fault}.")
    title = f"{hazard.id} {hazard.hazard}{'' if hazard.ok else ': broken'}"
    if hazard.only_because:
        text.insert(3, "Not for all: " + "; ".join(hazard.only_because) + ".")
    if hazard.harm:
        text.append(
            f"Bounds of the patient that were broken in some run: {', '.join(hazard.harm)}."
        )
    found = hazard.searched
    if found.worst is not None:
        text.append(_worst_searched(found.runs, (*found.problems, found.worst)[0]))
    if found.unavoidable:
        text.append(
            f"In {len(found.unavoidable)} searched runs a bound of time was broken that no "
            "withdrawal with the drive's whole voltage could have kept; people were told in time."
        )
    return Section(title, tuple(text), (_faults(detail.faults),), _plots(detail), anchor=hazard.id)


def _faults(faults: Sequence[FaultSummary]) -> Table:
    """Every fault of a hazard by its worst run."""
    columns = ("fault", "comes in", "strengths", "runs", "alarm", "ms", "bound", "safe, ms")
    rows = tuple(
        (
            fault.fault,
            fault.phase,
            fault.strengths,
            fault.runs,
            _name(fault.alarm),
            *_times(fault),
            fault.finding,
            fault.ok,
        )
        for fault in faults
    )
    return Table("Faults; of each the worst run", (*columns, "bound", "finding", "ok"), rows)


def _plots(detail: HazardDetail) -> tuple[Plot, ...]:
    """Strip chart of the worst run; none where the cycle was refused."""
    strip = detail.strip
    if strip is None:
        return ()
    time_s = strip.time_s.astype(float)
    marks = tuple(Level(mark.time_s, mark.name) for mark in detail.marks)

    def chart(title: str, y_label: str, *curves: tuple[str, Series, str]) -> Plot:
        drawn = tuple(Curve(label, values.astype(float), hue) for label, values, hue in curves)
        return Plot(title, "Time (s)", y_label, drawn, time_s, marks=marks)

    return (
        chart(
            "Catheter",
            "mm below the tube",
            ("Tip", strip.tip_mm, "tip"),
            ("Catheter head", strip.head_mm, "head"),
        ),
        chart(
            "Suction",
            "mmHg, %",
            ("Line vacuum (mmHg)", strip.vacuum_mmhg, "line-vacuum"),
            ("Valve open (%)", strip.valve_percent, "valve"),
        ),
        chart(
            "Answer",
            "Level",
            ("Governor: 2 hold, 3 withdraw, 4 torque off", strip.reaction, "reference"),
            ("Alarm: 1 low, 2 medium, 3 high", strip.priority, "contact"),
        ),
    )
