"""A safety case as a page, with a strip chart of each hazard's worst run."""

from collections.abc import Sequence

from opensuction.report.sheet import Cell, Curve, Level, Plot, Section, Sheet, Table
from opensuction.report.summary import Summary

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
            "left inside",
            "broken",
            "searched",
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
            ("left inside", _left_inside(data["left_inside"])),
        ),
        sections=(
            Section("Overview", (), (overview, *_stayed(details))),
            Section("How it was judged", METHOD),
            Section("Worst run of each hazard"),
            *(_section(hazard) for hazard in details),
        ),
    )


def _left_inside(found: Summary) -> str:
    """Runs that ended with the tip inside, in words."""
    if not found["count"]:
        return "in no run"
    return (
        f"in {found['count']} runs, {found['unavoidable']} of them unavoidable; "
        f"{found['told']} told high in time"
    )


def _stayed(details: Sequence[Summary]) -> tuple[Table, ...]:
    """Hazards in which a catheter stayed inside: why, and what a person must do."""
    rows = tuple(
        (
            Cell(hazard["id"], href=f"#{hazard['id']}"),
            hazard["left_inside"]["count"],
            hazard["left_inside"]["unavoidable"],
            hazard["left_inside"]["told"],
            "; ".join(hazard["unavoidable"]) or "nothing makes it so",
            " ".join(hazard["person"]),
        )
        for hazard in details
        if hazard["left_inside"]["count"]
    )
    if not rows:
        return ()
    columns = ("id", "runs", "unavoidable", "told high", "unavoidable because", "a person must")
    return (Table("Left inside at the end of the run", columns, rows),)


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
    left = hazard["left_inside"]
    return (
        Cell(hazard["id"], href=f"#{hazard['id']}"),
        hazard["hazard"],
        alarm,
        hazard["priority"],
        detected,
        detected_bound,
        hazard["safe_state"],
        safe,
        safe_bound,
        f"{left['count']} ({left['unavoidable']} unavoidable)" if left["count"] else "-",
        f"{hazard['broken']} of {hazard['runs']}",
        describe_search(hazard["searched"]),
        hazard["ok"],
    )


def describe_search(found: Summary) -> str:
    """How many searched runs broke a bound, or how near the worst of them came to one."""
    if found["broken"]:
        return f"{found['broken']} of {found['runs']} broken"
    worst = found["worst"]
    if worst is None:
        return "-"
    share = 100.0 * max(worst["share"], 0.0)
    return f"{share:.0f} % to {worst['bound']}" if share >= 0.5 else "nothing borne"


def _worst_searched(found: Summary) -> str:
    """The worst run of a search in a sentence."""
    worst = (*found["problems"], found["worst"])[0]
    at = "" if worst["after_s"] is None else f"@{worst['after_s']:g}"
    strength = "" if worst["strength"] is None else f"={worst['strength']:.3g}"
    end = f"broke {', '.join(worst['broken'])}" if worst["broken"] else "broke none"
    told = "people were told" if worst["told"] else "nobody was told"
    return (
        f"Worst of {found['runs']} searched runs: {worst['fault']}{at}{strength}, "
        f"{worst['patient']} by {worst['approach']}, seed {worst['seed']}: {worst['bound']} "
        f"{worst['worst']:.3g} {worst['unit']} of {worst['limit']:.3g}; it {end}, and {told}."
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
    if hazard["only_because"]:
        text.insert(3, "Not for all: " + "; ".join(hazard["only_because"]) + ".")
    if hazard["harm"]:
        text.append(
            f"Bounds of the patient that were broken in some run: {', '.join(hazard['harm'])}."
        )
    if hazard["searched"]["worst"] is not None:
        text.append(_worst_searched(hazard["searched"]))
    faults, plots = (_faults(hazard["faults"]),), _plots(hazard)
    return Section(title, tuple(text), faults, plots, anchor=hazard["id"])


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
