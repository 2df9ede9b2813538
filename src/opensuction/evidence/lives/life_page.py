"""A life as a page: its course over time, what became of its processes, and all that happened."""

from itertools import pairwise

from opensuction import __version__
from opensuction.evidence.lives.life_course import LANES, Course, ProcessState
from opensuction.evidence.lives.life_fault import LASTS, LifeFault
from opensuction.evidence.lives.life_record import LifeEvent, LifeResult
from opensuction.evidence.lives.lives import PlayedLife
from opensuction.evidence.lives.record_judge import INVARIANTS
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.report import wording
from opensuction.report.sheet import (
    Cell,
    Curve,
    Lane,
    Level,
    Plot,
    Rounded,
    Section,
    Sheet,
    Stretch,
    Table,
)

LEAD = (
    "Controller, recorder and supervisor are the processes that run a machine; computer, machine "
    "and patient are simulated. In-silico: no hardware, no patient."
)
HUES = {
    ProcessState.STARTING: "out",
    ProcessState.ALIVE: "suction",
    ProcessState.FROZEN: "in",
    ProcessState.DEAD: "fault",
}
TITLES = {"fault": "fault", "phase": "phase", "process": "process", "told": "people are told"}
"""Kinds of events, in words."""
PHASE, TOLD = "phase ", "people are told: "
CAPTION = (
    "By the truth of the twin. Shaded: phases as the controller shows them. Upright lines: faults."
)
LANES_CAPTION = (
    "A process that is starting does not work yet. One that is frozen stands still and is not "
    "dead; its locks stay held. Faults that last are as long as they last. Every instant is in the "
    "table of events."
)


def page(found: PlayedLife, life: LifeResult, course: Course) -> Sheet:
    """The page of a life. life: the same, as it was played."""
    tip, processes = _plots(life, course)
    broken = len(found.violations)
    verdict, lead = "Everything held", LEAD
    if broken:
        names = dict.fromkeys(one.invariant for one in found.violations)
        verdict = f"Broken: {', '.join(names)}"
        details = "; ".join(one.detail for one in found.violations)
        lead = f"{wording.capitalise(details)}. {LEAD}"
    return Sheet(
        title=f"Life {found.id}",
        verdict=verdict,
        good=not broken,
        lead=lead,
        run=(
            ("Seed", str(found.seed)),
            ("Version", __version__),
            ("Machine and patient", f"a neonate, seed {found.machine_seed}"),
            ("Faults", ", ".join(found.faults)),
            ("Simulated", f"{found.simulated_s:.1f} s"),
            ("Steps", f"{found.steps:,}"),
            ("Trace", found.trace),
        ),
        sections=(
            Section("Catheter", plots=(tip,)),
            Section("Processes", plots=(processes,)),
            Section("Faults", (), (_faults(life),)),
            Section("What had to hold", (), (_invariants(found),)),
            Section("Events", (), (_events(found),)),
            Section("Again", (f"{found.play} plays this life again, in this version.",)),
        ),
    )


def _plots(life: LifeResult, course: Course) -> tuple[Plot, Plot]:
    span = (min([0.0, *(one.at_s for one in life.events)]), course.ended_s)
    struck = _struck(life)
    return (
        Plot(
            "Tip of the catheter",
            "Time (s)",
            "mm below the tube",
            (Curve("Tip", course.tip_mm, "tip"),),
            course.time_s,
            CAPTION,
            marks=tuple(Level(at_s, _short(fault)) for fault, at_s in struck),
            shades=_phases(life.events, course.ended_s),
            span=span,
        ),
        Plot(
            "Processes, faults and what people are told",
            "Time (s)",
            "",
            (),
            caption=LANES_CAPTION,
            lanes=_lanes(life, course, struck),
            span=span,
        ),
    )


def _struck(life: LifeResult) -> list[tuple[LifeFault, float]]:
    """Faults that came, and when: a death in the middle of something, as it did."""
    known = {f"fault {fault.title}": fault for fault in life.life.faults}
    events = [one for one in life.events if one.kind == "fault"]
    return [(known[one.what], one.at_s) for one in events if one.what in known]


def _short(fault: LifeFault) -> str:
    return f"{fault.kind} {fault.target}" if fault.target else str(fault.kind)


def _phases(events: tuple[LifeEvent, ...], ended_s: float) -> tuple[Stretch, ...]:
    begun = [
        (one.at_s, one.what.removeprefix(PHASE).replace("-", "_"))
        for one in events
        if one.kind == "phase"
    ]
    return tuple(
        Stretch(wording.phase_words(name).label, wording.phase_words(name).kind, at_s, to_s)
        for (at_s, name), (to_s, _) in pairwise([*begun, (ended_s, "")])
    )


def _lanes(
    life: LifeResult, course: Course, struck: list[tuple[LifeFault, float]]
) -> tuple[Lane, ...]:
    processes = tuple(
        Lane(
            name,
            tuple(
                Stretch(one.state, HUES[one.state], one.from_s, one.to_s)
                for one in course.stretches
                if one.process == name
            ),
        )
        for name in LANES.values()
    )
    faults = tuple(
        Stretch(_short(fault), "fault", at_s, at_s + fault.seconds * (fault.kind in LASTS))
        for fault, at_s in struck
    )
    told = tuple(
        Stretch(one.what.removeprefix(TOLD), "notice", one.at_s, one.at_s)
        for one in life.events
        if one.kind == "told"
    )
    return (
        *processes,
        Lane("faults", faults, named=True),
        Lane("people are told", told, named=True),
    )


def _faults(life: LifeResult) -> Table:
    came = dict(_struck(life))
    rows = tuple(
        (
            _short(fault),
            "life" if fault.phase is None else name_of(Phase(fault.phase)),
            Rounded(fault.after_s, 4),
            Rounded(fault.seconds or None, 3),
            Rounded(came.get(fault), 3),
        )
        for fault in life.life.faults
    )
    columns = ("fault", "counted from the begin of", "after, s", "length or step, s", "came at, s")
    return Table("A dash: none, or it never came", columns, rows)


def _invariants(found: PlayedLife) -> Table:
    said: dict[str, list[str]] = {name: [] for name in INVARIANTS}
    for one in found.violations:
        said[one.invariant].append(one.detail)
    rows = tuple(
        (name, words, not said[name], "; ".join(said[name])) for name, words in INVARIANTS.items()
    )
    return Table("In every life", ("name", "what must hold", "held", "what broke it"), rows)


def _events(found: PlayedLife) -> Table:
    rows = tuple(
        (
            Rounded(one.at_s, 3),
            TITLES[one.kind],
            Cell(
                one.what.removeprefix(PHASE).removeprefix(TOLD).removeprefix("fault "),
                "bad" if one.kind == "fault" else "",
            ),
        )
        for one in found.events
    )
    return Table("Seconds from the life's begin", ("s", "kind", "event"), rows)
