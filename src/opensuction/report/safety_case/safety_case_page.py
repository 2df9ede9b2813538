"""A safety case as a page, with a strip chart of each hazard's worst run."""

from collections.abc import Sequence

from opensuction.report.sheet import Curve, Level, Plot, Section, Sheet, Table
from opensuction.report.summary import Summary

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


def page(data: Summary, details: Sequence[Summary]) -> Sheet:
    """The page. data: the JSON object of the command. details: of each of its hazards."""
    held = sum(hazard["ok"] for hazard in details)
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
        tuple(_overview(hazard) for hazard in details),
    )
    return Sheet(
        title="Safety case",
        verdict=f"{held} of {len(details)} hazards answered within their bounds",
        good=data["ok"],
        lead=LEAD,
        run=(
            ("version", data["version"]),
            ("runs", str(data["runs"])),
            ("seeds", ", ".join(str(seed) for seed in data["seeds"])),
        ),
        sections=(
            Section("Overview", METHOD, (overview,)),
            *(_section(hazard) for hazard in details),
        ),
    )


TIMES = ("detected_ms", "detected_bound_ms", "safe_ms", "safe_bound_ms")
"""Of the worst run, each with its bound, in whole ms."""


def _times(entry: Summary) -> tuple[int | None, ...]:
    return tuple(None if entry[name] is None else round(entry[name]) for name in TIMES)


def _name(alarm: str | None) -> str:
    return "-" if alarm is None else alarm.replace("_", " ")


def _overview(hazard: Summary) -> tuple[object, ...]:
    alarm = _name(hazard["alarm"])
    if hazard["refusal"]:
        alarm = "refused before the start"
    elif hazard["within_limits"]:
        alarm = "not needed: within every limit"
    detected, detected_bound, safe, safe_bound = _times(hazard)
    return (
        hazard["id"],
        hazard["hazard"],
        alarm,
        hazard["priority"],
        detected,
        detected_bound,
        hazard["safe_state"],
        safe,
        safe_bound,
        f"{hazard['broken']} of {hazard['runs']}",
        hazard["ok"],
    )


def _section(hazard: Summary) -> Section:
    text = [
        f"Cause: {hazard['cause']}. Effect: {hazard['effect']} ({hazard['severity']}).",
        f"Detection: {hazard['detection']}. Control: {hazard['control']}.",
        f"Safe state: {hazard['safe_state_words']}.",
        "Why these bounds: " + " ".join(hazard["because"]),
    ]
    if hazard["sentence"]:
        text.append(f"What a person reads: {hazard['sentence']}")
    requirements = ", ".join(hazard["requirements"])
    text.append(f"Requirements: {requirements}. Worst run: {hazard['fault']}.")
    title = f"{hazard['id']} {hazard['hazard']}{'' if hazard['ok'] else ': broken'}"
    return Section(title, tuple(text), (_faults(hazard["faults"]),), _plots(hazard))


def _faults(faults: Sequence[Summary]) -> Table:
    """Every fault of a hazard by its worst run."""
    columns = ("fault", "comes in", "strengths", "runs", "alarm", "ms", "bound", "safe, ms")
    rows = tuple(
        (
            entry["fault"],
            entry["phase"],
            entry["strengths"],
            entry["runs"],
            _name(entry["alarm"]),
            *_times(entry),
            entry["finding"],
            entry["ok"],
        )
        for entry in faults
    )
    return Table("Faults; of each the worst run", (*columns, "bound", "finding", "ok"), rows)


def _plots(hazard: Summary) -> tuple[Plot, ...]:
    """Strip chart of the worst run; none where the cycle was refused."""
    strip = hazard["strip"]
    if strip is None:
        return ()
    marks = tuple(Level(mark["time_s"], mark["name"]) for mark in hazard["marks"])

    def chart(title: str, y_label: str, *curves: tuple[str, str, str]) -> Plot:
        drawn = tuple(Curve(label, strip[name].astype(float), hue) for label, name, hue in curves)
        return Plot(title, "Time (s)", y_label, drawn, strip["time_s"].astype(float), marks=marks)

    return (
        chart(
            "Catheter",
            "mm below the tube",
            ("Tip", "tip_mm", "tip"),
            ("Catheter head", "head_mm", "head"),
        ),
        chart(
            "Suction",
            "mmHg, %",
            ("Line vacuum (mmHg)", "vacuum_mmhg", "line-vacuum"),
            ("Valve open (%)", "valve_percent", "valve"),
        ),
        chart(
            "Answer",
            "Level",
            ("Governor: 2 hold, 3 withdraw, 4 torque off", "reaction", "reference"),
            ("Alarm: 1 low, 2 medium, 3 high", "priority", "contact"),
        ),
    )
