"""Contradictions between a report and its JSON, found by rules independent of the report's own."""

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from opensuction.report import figures, headline, narrative
from opensuction.report.figure import FigureVerdict
from opensuction.report.headline import Headline
from opensuction.result.cycle_result import CycleResult
from opensuction.result.plain import to_json

GREEN = FigureVerdict.GOOD

DENIED_BY_ALARM = {
    "negative-pressure-time": ("Time under negative pressure", r"Suction lasted .*within"),
    "in-airway-time": ("Time in the airway", r"in the airway for .*within"),
    "withdrawal-time": ("Time in the airway", ""),
    "tip-beyond-cap": ("Deepest tip position", r"that it must never pass\.$"),
    "carina-missed": ("Deepest tip position", r"never pass\.$"),
    "contact-time": ("Force on the carina", r"did not touch the carina\.$"),
    "spo2-low": ("Lowest oxygen saturation", ""),
    "heart-rate-low": ("Lowest heart rate", ""),
    "airway-pressure-unsafe": ("Airway pressure", ""),
    "circuit-disconnected": ("Airway pressure", ""),
    "lung-volume-lost": ("Lung volume lost", ""),
    "vacuum-exceeded": ("Highest vacuum", ""),
    "pump-runaway": ("Highest vacuum", ""),
    "line-clogged": ("Secretions removed", r"the next pass may follow"),
    "vacuum-lost": ("Secretions removed", r"the next pass may follow"),
    "pass-limit-reached": ("Secretions removed", r"the next pass may follow"),
    "withdrawal-blocked": ("Catheter at the end", ""),
}
"""By the condition: the figure that may not be green, and a sentence that may not be said."""

DENIED_BY_HARM = {
    "left-inside": "Catheter at the end",
    "tip-past-cap": "Deepest tip position",
    "force": "Force on the carina",
    "contact-time": "Force on the carina",
    "vacuum": "Highest vacuum",
    "suction-time": "Time under negative pressure",
    "airway-time": "Time in the airway",
    "advance-under-vacuum": "Highest vacuum",
    "airway-pressure": "Airway pressure",
    "lung-volume": "Lung volume lost",
    "saturation": "Lowest oxygen saturation",
}
"""By the broken bound: the figure that may not be green."""

RED_PERCENT = 80.0
"""No saturation below it is anything but red."""
POOR_PERCENT = 50.0
"""Less cleared than that is never green."""
RANK = {"low": 1, "medium": 2, "high": 3}
HOPES = r"the catheter comes out|was drawn out without|is drawn out first"
"""What may not be said of a catheter that is still inside."""


def _raised(data: Mapping[str, Any]) -> dict[str, int]:
    """Conditions that anybody raised, with their priority."""
    found = {entry["condition"]: RANK[entry["priority"]] for entry in data["alarms"]}
    for entry in data.get("told") or []:
        found.setdefault(entry["what"].replace("_", "-"), RANK[entry["priority"]])
    return found


class Read(NamedTuple):
    """A report as somebody reads it, beside what its JSON holds."""

    data: Mapping[str, Any]
    first: Headline
    sentences: list[str]
    verdicts: dict[str, FigureVerdict]
    raised: dict[str, int]
    harm: list[str]

    @property
    def text(self) -> str:
        """Every word of it."""
        return " ".join([self.first.text, self.first.lead, self.first.look, *self.sentences])


def contradictions(result: CycleResult) -> list[str]:
    """Sentences on what a report of this result denies; empty for a truthful one.

    The rules read the JSON, not the record that the report reads.
    """
    data = to_json(result)
    report = Read(
        data,
        headline.headline(result),
        narrative.sentences(result),
        {figure.name: figure.verdict for figure in figures.figures(result)},
        _raised(data),
        list(data.get("harm") or []),
    )
    rules = (_first_line, _inside, _comfort, _alarms, _harm, _figures)
    return [found for rule in rules for found in rule(report)]


def _first_line(report: Read) -> Iterator[str]:
    """It names the most urgent thing, and is green for none."""
    first, raised = report.first, report.raised
    if report.data["tip"].get("inside_at_end"):
        start = "CATHETER IS STILL IN THE AIRWAY"
    else:
        start = "PATIENT AT RISK" if report.harm else ""
    if not first.text.startswith(start):
        yield f"'{start}' is missing in the first line '{first.text}'"
    if raised and not start:
        wanted = [name for name, rank in raised.items() if rank == max(raised.values())]
        if not any(_sentence(report.data, name) in first.text for name in wanted):
            yield f"none of {wanted} in the first line '{first.text}'"
    is_well = report.data["outcome"] == "completed" and not raised and not start
    if not is_well and first.verdict is GREEN:
        yield "a green first line"


def _inside(report: Read) -> Iterator[str]:
    if not report.data["tip"].get("inside_at_end"):
        return
    if GREEN in (report.verdicts["Catheter at the end"], report.verdicts["Time in the airway"]):
        yield "left inside beside a green figure"
    if re.search(HOPES, report.text):
        yield "left inside, and a sentence brings it out"


def _comfort(report: Read) -> Iterator[str]:
    if report.raised and re.search(
        "no alarm was raised|Every figure|Nobody was told|all is well", report.text
    ):
        yield f"{sorted(report.raised)}, and a sentence knows of no alarm"


def _alarms(report: Read) -> Iterator[str]:
    for name in report.raised:
        figure, pattern = DENIED_BY_ALARM.get(name, ("", ""))
        if report.verdicts.get(figure) is GREEN:
            yield f"'{figure}' is green beside {name}"
        if pattern and any(re.search(pattern, sentence) for sentence in report.sentences):
            yield f"a sentence denies {name}"


def _harm(report: Read) -> Iterator[str]:
    for name in report.harm:
        if report.verdicts[DENIED_BY_HARM[name]] is GREEN:
            yield f"'{DENIED_BY_HARM[name]}' is green beside harm {name}"


def _figures(report: Read) -> Iterator[str]:
    """What figures alone would not let pass."""
    data, is_green = report.data, report.first.verdict is GREEN
    lowest = data.get("spo2_nadir_percent")
    is_red = report.verdicts["Lowest oxygen saturation"] is FigureVerdict.BAD
    if lowest is not None and lowest < RED_PERCENT and (is_green or not is_red):
        yield f"a saturation of {lowest} % that is not red"
    percent = data["secretion"]["removed_percent"]
    is_poor = percent is not None and percent < POOR_PERCENT and data["outcome"] == "completed"
    if is_poor and (is_green or report.verdicts["Secretions removed"] is GREEN):
        yield f"{percent} % removed, and green"


def _sentence(data: Mapping[str, Any], name: str) -> str:
    """The words of a condition as the JSON has them; where the catheter is inside, its name."""
    for entry in [*data["alarms"], *(data.get("told") or [])]:
        if (entry.get("condition") or entry.get("what")) == name:
            return str(entry["sentence"])
    return name
