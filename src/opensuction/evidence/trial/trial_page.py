"""A trial as a page of Markdown, as `docs/evidence` holds it: what was asked, who judged."""

import math
from collections.abc import Iterable, Sequence

from opensuction.evidence.trial import draw, trial_summary
from opensuction.evidence.trial.draw import FAULTS
from opensuction.result.trial_result import (
    EndpointSpread,
    FaultCount,
    PatientEndpoints,
    ShareBound,
    TrialBounds,
    TrialResult,
    Violation,
)
from opensuction.simulation.injection.fault_allowance import ALLOWANCES, OWN_HARM, Allowance

KINDS_SHOWN = 40
"""Kinds of violations that are listed, the most frequent first."""
NUMBERS_SHOWN = 5
"""Cycles that are named for each of them."""
SAID_SHOWN = 40

EACH: dict[FaultCount, str] = {
    "none": "without a fault",
    "single": "with a fault each",
    "double": "with two faults each",
}
ENDPOINTS = (
    "cycles",
    "completed",
    "secretions removed, mL",
    "of what was there, %",
    "lowest saturation, %",
    "lung volume lost, mL",
    "time in the airway, s",
    "suction time, s",
    "largest force on the carina, N",
)
"""Rows of the table of endpoints; `_endpoint_column` has their values."""


def list_held(bounds: TrialBounds) -> tuple[tuple[str, ShareBound], ...]:
    """Each share of cycles that broke something, with the words for what they are held against."""
    return (
        ("what the controller sends, every cycle", bounds.commands),
        ("bounds of the patient, no fault", bounds.patient.none),
        ("bounds of the patient, one fault", bounds.patient.single),
        ("bounds of the patient, two faults", bounds.patient.double),
        ("nothing said that is not so, no fault", bounds.false_alarms),
    )


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    lines = [head, ["---"] * len(head), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def title(result: TrialResult) -> str:
    """Title of the page."""
    return f"Trial: {result.cycles:,} cycles {EACH[result.trial.faults]}"


def command(result: TrialResult) -> str:
    """The command line of the trial."""
    words = trial_summary.play_command(result.trial, 0)
    return words.replace("--play 0", f"--cycles {result.asked}")


def _asked(result: TrialResult) -> list[str]:
    trial, watched = result.trial, result.watched_s
    kinds = draw.list_kinds(trial.cohort)
    play_any = trial_summary.play_command(trial, "NUMBER")
    patients = ", ".join(f"`{name}`" for name in dict.fromkeys(kind.patient for kind in kinds))
    approaches = " and ".join(dict.fromkeys(kind.approach for kind in kinds))
    lines = [
        f"Date: {result.date_utc}. In-silico: all of it happened on the digital twin. Version "
        f"{result.version}, sources {result.sources}.{_effort(result)}",
        "",
        f"`{command(result)}`",
        "",
        f"**Scope.** {result.cycles:,} cycles on {result.machines:,} drawn machines, "
        f"each with a drawn patient ({patients}), by {approaches}, compensation "
        f"`{trial.compensation}`, pre-oxygenation {trial.preoxygenation} where guidelines "
        "ask for it. Sensors err as such parts are sold, what the controller is told of the "
        "machine is nominal, and patients cough, breathe on their own, are moved and leak. "
        f"{_asked_of_faults(trial.faults)} Every cycle follows from its number "
        f"alone, and can be played again: `{play_any}` writes its report.",
        "",
        "**Judgement.** What happened to the patient: `oracle/`, from the twin's truth alone, "
        "over the whole cycle and after it, less what a fault states that it makes unavoidable. "
        "What the controller sends: its invariants, which no fault excuses. Watched for "
        f"{watched.most:g} s once the machine was at rest: machine and patient "
        "together until the machine could do nothing new and whoever must be told had been "
        f"({watched.mean:.0f} s in the mean, the whole time in "
        f"{watched.whole:,} cycles), then the patient alone.",
    ]
    if not result.complete:
        lines += ["", f"**Not complete:** {result.cycles:,} of {result.asked:,} cycles."]
    return lines


def _effort(result: TrialResult) -> str:
    if result.cycles_per_s is None:
        return ""
    return f" {result.cycles_per_s:.0f} cycles a second by {result.workers} processes."


def _asked_of_faults(faults: FaultCount) -> str:
    if faults == "none":
        return "Nothing is wrong with any of them."
    many = "one" if faults == "single" else "two, each drawn on its own,"
    return (
        f"Injected: {many} of {len(FAULTS)} faults, anywhere in its range of strengths, at an "
        "instant of the time that the tip is inside or a second before."
    )


def _counts(result: TrialResult) -> list[str]:
    rows = [
        (words, f"{one.cycles:,}", f"{one.broken:,}", f"{one.upper_percent:.2g} %")
        for words, one in list_held(result.bounds)
        if one.cycles
    ]
    return _table(("held against", "cycles", "broken", "share at most (95 %)"), rows)


def _not_counted(result: TrialResult) -> list[str]:
    found = result.not_counted
    if not found.faults:
        return []
    many = ", ".join(f"`{name}` {count}" for name, count in found.by_fault.items())
    return [
        "",
        "## Not counted",
        "",
        "Faults that came when the first of their cycle had already had the catheter drawn out, "
        f"and could do nothing any more: {found.faults:,}. Their cycles count with one. By "
        f"fault: {many}.",
    ]


def _violations(result: TrialResult) -> list[str]:
    kinds: dict[tuple[str, str], list[Violation]] = {}
    for one in result.violations:
        bound = f"{one.bound}{' (command)' if one.is_command else ''}"
        kinds.setdefault((" + ".join(one.faults) or "none", bound), []).append(one)
    lines = ["", "## Violations", ""]
    if not kinds:
        return [*lines, "None."]
    rows = []
    for (faults, bound), found in sorted(kinds.items(), key=lambda item: -len(item[1])):
        worst = max(found, key=_excess)
        numbers = ", ".join(str(one.number) for one in found[:NUMBERS_SHOWN])
        worst_limit = (_number(worst.worst), _number(worst.limit))
        rows.append((faults, bound, str(len(found)), *worst_limit, numbers))
    head = ("faults", "what was broken", "cycles", "worst", "limit", "numbers")
    lines += _table(head, rows[:KINDS_SHOWN])
    if len(rows) > KINDS_SHOWN:
        lines += ["", f"And {len(rows) - KINDS_SHOWN} kinds more, in `trial.json`."]
    return lines


def _excess(one: Violation) -> float:
    return math.inf if one.worst is None else abs(one.worst - one.limit)


def _number(value: float | None) -> str:
    return "no number" if value is None else f"{value:.3g}"


def _left_inside(result: TrialResult) -> list[str]:
    left = result.left_inside
    lines = ["", "## Left inside", ""]
    if result.too_slow:
        lines += [
            f"{result.too_slow:,} cycles with one fault broke a bound of time that no withdrawal "
            "with the drive's whole voltage could have kept; all of them were told in time.",
            "",
        ]
    if not left.total.count:
        return [*lines, "No cycle ended with the tip in the airway."]
    slowest = left.slowest_told_s
    when = "" if slowest is None else f" (the slowest after {slowest:.1f} s)"
    lines.append(
        f"{left.total.count:,} cycles ended with the tip in the airway; "
        f"{left.total.unavoidable:,} of them nothing of the machine could have prevented, "
        f"{left.total.told:,} were told with high priority in time{when}."
    )
    rows = [
        (
            str(one.count),
            ", ".join(f"`{name}` {count}" for name, count in list(one.faults.items())[:8])
            + (" ..." if len(one.faults) > 8 else ""),
            one.unavoidable or "**something could have brought it out**",
            one.person,
        )
        for one in left.because
    ]
    return [*lines, "", *_table(("cycles", "faults", "because", "a person must"), rows)]


def _said(result: TrialResult) -> list[str]:
    if not result.counted.none:
        return _said_before(result.false_before_fault)
    lines = [
        "",
        "## Alarms in cycles without a fault",
        "",
        f"Of {result.counted.none:,} cycles without a fault {result.false_alarms:,} tripped, "
        f"were broken off or told something that was not so; {result.true_alarms:,} told "
        f"something of the patient that was. {result.broken_off:,} were not completed.",
    ]
    rows = [
        (
            str(one.number),
            f"{one.patient}, {one.approach}",
            ", ".join(one.false) or "-",
            ", ".join(one.true) or "-",
            "yes" if one.completed else "no",
        )
        for one in sorted(result.said, key=lambda one: not one.false)[:SAID_SHOWN]
    ]
    if rows:
        lines += ["", *_table(("number", "cycle", "not so", "so", "completed"), rows)]
    if len(result.said) > SAID_SHOWN:
        lines += ["", f"And {len(result.said) - SAID_SHOWN} cycles more, in `trial.json`."]
    return lines


def _said_before(cycles: int) -> list[str]:
    """Lines on false alarms and trips before the fault of a cycle came."""
    if not cycles:
        return []
    return [
        "",
        f"In {cycles:,} cycles something that was not so tripped or was told before the fault "
        "came; cycles of one machine share what comes before. `--faults none` asks that question.",
    ]


def _spread(one: EndpointSpread | None, digits: int) -> str:
    if one is None:
        return "-"
    return f"{one.median:.{digits}f} ({one.p5:.{digits}f} to {one.p95:.{digits}f})"


def _endpoint_column(one: PatientEndpoints) -> tuple[str, ...]:
    """Values of the rows `ENDPOINTS` for one patient."""
    return (
        f"{one.cycles:,}",
        f"{one.completed:,}",
        _spread(one.removed_ml, 2),
        _spread(one.removed_percent, 0),
        _spread(one.spo2_least_percent, 1),
        _spread(one.lung_volume_loss_ml, 0),
        _spread(one.in_airway_s, 1),
        _spread(one.suction_s, 1),
        _spread(one.force_peak_n, 3),
    )


def _endpoints(result: TrialResult) -> list[str]:
    columns = [_endpoint_column(one) for one in result.endpoints.values()]
    return [
        "",
        "## Endpoints",
        "",
        "By the truth, of all cycles, those that were broken off among them: median (5th to 95th "
        "percentile).",
        "",
        *_table(
            ("", *(f"`{name}`" for name in result.endpoints)),
            zip(ENDPOINTS, *columns, strict=True),
        ),
    ]


def _say_more(one: Allowance) -> str:
    """Size of an allowance, in words."""
    if math.isfinite(one.over_strength):
        less = f"{one.least:g} and {one.over_strength:g} / its strength"
        return f"{less}, {one.more:g} at most"
    more = "its strength" if one.for_strength else f"{one.more:g}"
    return more if math.isinf(one.up_to) else f"{more}, up to strength {one.up_to:g}"


def _allowances(result: TrialResult) -> list[str]:
    if result.trial.faults == "none":
        return []
    rows = [
        (
            f"`{one.fault.title}`",
            one.bound,
            _say_more(one),
            one.reason,
        )
        for one in ALLOWANCES
    ]
    rows += [(f"`{one.fault.title}`", ", ".join(one.bounds), "all", one.reason) for one in OWN_HARM]
    head = ("fault", "bound", "on top of the common one", "because")
    return ["", "## Bounds that faults state for themselves", "", *_table(head, rows)]


def _untold(result: TrialResult) -> list[str]:
    rows = [
        (f"`{name}`", str(one.cycles), str(one.unnoticed))
        for name, one in result.untold.items()
        if one.unnoticed
    ]
    if not rows:
        return []
    head = ("fault, alone", "cycles", "of these untold")
    return ["", "## Faults without an alarm", "", *_table(head, rows)]


def _not_asked(result: TrialResult) -> list[str]:
    words: dict[FaultCount, str] = {
        "none": "Any fault; ",
        "single": "Two faults at once; faults of the set-up; ",
        "double": "More than two faults at once; faults of the set-up; ",
    }
    return [
        "",
        "## Not asked",
        "",
        f"{words[result.trial.faults]}more than one cycle in a row; a person at the buttons; "
        f"another compensation than `{result.trial.compensation}`; any machine of metal.",
    ]


def markdown(result: TrialResult) -> str:
    """The page of a trial."""
    refused = result.refused
    lines = [
        f"# {title(result)}",
        "",
        *_asked(result),
        "",
        *_counts(result),
        *_violations(result),
        *_left_inside(result),
        *_said(result),
        *_endpoints(result),
        *_not_counted(result),
        *_allowances(result),
        *_untold(result),
        *_not_asked(result),
    ]
    if refused:
        lines += ["", f"Drawn machines refused before they began: {len(refused)}, for example:"]
        lines += ["", f"- {refused[0]}"]
    return "\n".join(lines) + "\n"
