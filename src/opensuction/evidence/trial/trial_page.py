"""A trial as a page of Markdown, as `docs/evidence` holds it: what was asked, who judged."""

import math
from collections.abc import Iterable, Sequence

from opensuction.evidence.trial import cohort, trial_summary
from opensuction.evidence.trial.draw import FAULTS, Trial
from opensuction.result.plain import Json
from opensuction.simulation.injection.fault_allowance import ALLOWANCES, OWN_HARM, Allowance

KINDS_SHOWN = 40
"""Kinds of violations that are listed, the most frequent first."""
NUMBERS_SHOWN = 5
"""Cycles that are named for each of them."""
SAID_SHOWN = 40

HELD = {
    "commands": "what the controller sends, every cycle",
    "none": "bounds of the patient, no fault",
    "single": "bounds of the patient, one fault",
    "double": "bounds of the patient, two faults",
    "false_alarms": "nothing said that is not so, no fault",
}
"""By the key of `bounds`."""
EACH = {"none": "without a fault", "single": "with a fault each", "double": "with two faults each"}
ENDPOINTS = {
    "removed_ml": ("secretions removed, mL", 2),
    "removed_percent": ("of what was there, %", 0),
    "spo2_least_percent": ("lowest saturation, %", 1),
    "lung_volume_loss_ml": ("lung volume lost, mL", 0),
    "in_airway_s": ("time in the airway, s", 1),
    "suction_s": ("suction time, s", 1),
    "force_peak_n": ("largest force on the carina, N", 3),
}
"""Words and digits of each endpoint."""


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    lines = [head, ["---"] * len(head), *rows]
    return [f"| {' | '.join(line)} |" for line in lines]


def title(data: Json) -> str:
    """How a trial is called."""
    return f"Trial: {data['cycles']:,} cycles {EACH[data['trial']['faults']]}"


def command(data: Json) -> str:
    """The command line of the trial."""
    words = trial_summary.play_command(Trial(**data["trial"]), 0)
    return words.replace("--play 0", f"--cycles {data['asked']}")


def _asked(data: Json, date: str) -> list[str]:
    trial = data["trial"]
    kinds = cohort.list_kinds(trial["cohort"])
    patients = ", ".join(f"`{name}`" for name in dict.fromkeys(kind.patient for kind in kinds))
    approaches = " and ".join(dict.fromkeys(kind.approach for kind in kinds))
    lines = [
        f"Date: {date}. In-silico: all of it happened on the digital twin. Version "
        f"{data['version']}, sources {data['sources']}.{_effort(data)}",
        "",
        f"`{command(data)}`",
        "",
        f"**What was asked.** {data['cycles']:,} cycles on {data['machines']:,} drawn machines, "
        f"each with a drawn patient ({patients}), by {approaches}, compensation "
        f"`{trial['compensation']}`, pre-oxygenation {trial['preoxygenation']} where guidelines "
        "ask for it. Sensors err as such parts are sold, what the controller is told of the "
        "machine is nominal, and patients cough, breathe on their own, are moved and leak. "
        f"{_asked_of_faults(trial['faults'])} Every cycle follows from its number "
        f"alone, and can be played again: `{_play_any(data)}` writes its report.",
        "",
        "**Who judged.** What happened to the patient: `oracle/`, from the twin's truth alone, "
        "over the whole cycle and after it, less what a fault states that it makes unavoidable. "
        "What the controller sends: its invariants, which no fault excuses. Watched for "
        f"{data['watched_s']['most']:g} s once the machine was at rest: machine and patient "
        "together until the machine could do nothing new and whoever must be told had been "
        f"({data['watched_s']['mean']:.0f} s in the mean, the whole time in "
        f"{data['watched_s']['whole']:,} cycles), then the patient alone.",
    ]
    if not data["complete"]:
        lines += ["", f"**Not complete:** {data['cycles']:,} of {data['asked']:,} cycles."]
    return lines


def _effort(data: Json) -> str:
    if data["cycles_per_s"] is None:
        return ""
    return f" {data['cycles_per_s']:.0f} cycles a second by {data['workers']} processes."


def _asked_of_faults(faults: str) -> str:
    if faults == "none":
        return "Nothing is wrong with any of them."
    many = "one" if faults == "single" else "two, each drawn on its own,"
    return (
        f"Injected: {many} of {len(FAULTS)} faults, anywhere in its range of strengths, at an "
        "instant of the time that the tip is inside or a second before."
    )


def _play_any(data: Json) -> str:
    return trial_summary.play_command(Trial(**data["trial"]), "NUMBER")


def _counts(data: Json) -> list[str]:
    rows = [
        (words, f"{one['cycles']:,}", f"{one['broken']:,}", f"{one['upper_percent']:.2g} %")
        for key, words in HELD.items()
        if (one := data["bounds"][key])["cycles"]
    ]
    return _table(("held against", "cycles", "broken", "share at most (95 %)"), rows)


def _not_counted(data: Json) -> list[str]:
    found = data["not_counted"]
    if not found["faults"]:
        return []
    many = ", ".join(f"`{name}` {count}" for name, count in found["by_fault"].items())
    return [
        "",
        "## Not counted",
        "",
        "Faults that came when the first of their cycle had already had the catheter drawn out, "
        f"and could do nothing any more: {found['faults']:,}. Their cycles count with one. By "
        f"fault: {many}.",
    ]


def _violations(data: Json) -> list[str]:
    kinds: dict[tuple[str, str], list[Json]] = {}
    for one in data["violations"]:
        bound = f"{one['bound']}{' (command)' if one['is_command'] else ''}"
        kinds.setdefault((" + ".join(one["faults"]) or "none", bound), []).append(one)
    lines = ["", "## Violations", ""]
    if not kinds:
        return [*lines, "None."]
    rows = []
    for (faults, bound), found in sorted(kinds.items(), key=lambda item: -len(item[1])):
        worst = max(found, key=_excess)
        numbers = ", ".join(str(one["number"]) for one in found[:NUMBERS_SHOWN])
        rows.append(
            (
                faults,
                bound,
                str(len(found)),
                _number(worst["worst"]),
                _number(worst["limit"]),
                numbers,
            )
        )
    head = ("faults", "what was broken", "cycles", "worst", "limit", "numbers")
    lines += _table(head, rows[:KINDS_SHOWN])
    if len(rows) > KINDS_SHOWN:
        lines += ["", f"And {len(rows) - KINDS_SHOWN} kinds more, in `trial.json`."]
    return lines


def _excess(one: Json) -> float:
    return math.inf if one["worst"] is None else abs(one["worst"] - one["limit"])


def _number(value: float | None) -> str:
    return "no number" if value is None else f"{value:.3g}"


def _left_inside(data: Json) -> list[str]:
    found = data["left_inside"]
    lines = ["", "## Left inside", ""]
    if not found["count"]:
        return [*lines, "No cycle ended with the tip in the airway."]
    slowest = found["slowest_told_s"]
    when = "" if slowest is None else f" (the slowest after {slowest:.1f} s)"
    lines.append(
        f"{found['count']:,} cycles ended with the tip in the airway; {found['unavoidable']:,} of "
        f"them nothing of the machine could have prevented, {found['told']:,} were told with high "
        f"priority in time{when}."
    )
    rows = [
        (
            str(one["count"]),
            ", ".join(f"`{name}` {count}" for name, count in list(one["faults"].items())[:8])
            + (" ..." if len(one["faults"]) > 8 else ""),
            one["unavoidable"] or "**something could have brought it out**",
            one["person"],
        )
        for one in found["because"]
    ]
    return [*lines, "", *_table(("cycles", "faults", "because", "a person must"), rows)]


def _said(data: Json) -> list[str]:
    if not data["counted"]["none"]:
        return _said_before(data["false_before_fault"])
    lines = [
        "",
        "## What was said of sound cycles",
        "",
        f"Of {data['counted']['none']:,} cycles without a fault {data['false_alarms']:,} tripped, "
        f"were broken off or told something that was not so; {data['true_alarms']:,} told "
        f"something of the patient that was. {data['broken_off']:,} were not completed.",
    ]
    rows = [
        (
            str(one["number"]),
            f"{one['patient']}, {one['approach']}",
            ", ".join(one["false"]) or "-",
            ", ".join(one["true"]) or "-",
            "yes" if one["completed"] else "no",
        )
        for one in sorted(data["said"], key=lambda one: not one["false"])[:SAID_SHOWN]
    ]
    if rows:
        lines += ["", *_table(("number", "cycle", "not so", "so", "completed"), rows)]
    if len(data["said"]) > SAID_SHOWN:
        lines += ["", f"And {len(data['said']) - SAID_SHOWN} cycles more, in `trial.json`."]
    return lines


def _said_before(cycles: int) -> list[str]:
    """What was said of a machine that was sound until its fault came."""
    if not cycles:
        return []
    return [
        "",
        f"In {cycles:,} cycles something that was not so tripped or was told before the fault "
        "came; cycles of one machine share what comes before. `--faults none` asks that question.",
    ]


def _spread(one: Json | None, digits: int) -> str:
    if one is None:
        return "-"
    values = [f"{one[key]:.{digits}f}" for key in ("median", "p5", "p95")]
    return f"{values[0]} ({values[1]} to {values[2]})"


def _endpoints(data: Json) -> list[str]:
    patients = data["endpoints"]
    rows = [
        ("cycles", *(f"{one['cycles']:,}" for one in patients.values())),
        ("completed", *(f"{one['completed']:,}" for one in patients.values())),
        *(
            (words, *(_spread(one.get(name), digits) for one in patients.values()))
            for name, (words, digits) in ENDPOINTS.items()
        ),
    ]
    return [
        "",
        "## Endpoints",
        "",
        "By the truth, of all cycles, those that were broken off among them: median (5th to 95th "
        "percentile).",
        "",
        *_table(("", *(f"`{name}`" for name in patients)), rows),
    ]


def _say_more(one: Allowance) -> str:
    """How much an allowance is."""
    if math.isfinite(one.over_strength):
        less = f"{one.least:g} and {one.over_strength:g} / its strength"
        return f"{less}, {one.more:g} at most"
    more = "its strength" if one.for_strength else f"{one.more:g}"
    return more if math.isinf(one.up_to) else f"{more}, up to strength {one.up_to:g}"


def _allowances(data: Json) -> list[str]:
    if data["trial"]["faults"] == "none":
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


def _untold(data: Json) -> list[str]:
    rows = [
        (f"`{name}`", str(one["cycles"]), str(one["unnoticed"]))
        for name, one in data["untold"].items()
        if one["unnoticed"]
    ]
    if not rows:
        return []
    head = ("fault, alone", "cycles", "of these untold")
    return ["", "## What nothing told", "", *_table(head, rows)]


def _not_asked(data: Json) -> list[str]:
    words = {
        "none": "Any fault; ",
        "single": "Two faults at once; faults of the set-up; ",
        "double": "More than two faults at once; faults of the set-up; ",
    }
    return [
        "",
        "## Not asked",
        "",
        f"{words[data['trial']['faults']]}more than one cycle in a row; a person at the buttons; "
        f"another compensation than `{data['trial']['compensation']}`; any machine of metal.",
    ]


def markdown(data: Json, date: str) -> str:
    """The page of a trial. data: its JSON object. date: as it shall stand there."""
    refused = data["refused"]
    lines = [
        f"# {title(data)}",
        "",
        *_asked(data, date),
        "",
        *_counts(data),
        *_violations(data),
        *_left_inside(data),
        *_said(data),
        *_endpoints(data),
        *_not_counted(data),
        *_allowances(data),
        *_untold(data),
        *_not_asked(data),
    ]
    if refused:
        lines += ["", f"Drawn machines refused before they began: {len(refused)}, for example:"]
        lines += ["", f"- {refused[0]}"]
    return "\n".join(lines) + "\n"
