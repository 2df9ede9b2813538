"""The page on phases, made from the table of transitions."""

from docs.generator.phase_picture import words
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.check import ORDER
from opensuction.procedure.cycle.transition import BROKEN_OFF, NORMAL, Event

Table = dict[tuple[Phase, Event], Phase]

PAGE = """# Phases

Generated from `opensuction.procedure.cycle.transition`; a test compares the two.

![Phases and the events between them](../pictures/phases.svg)

One suction cycle, teaching and service, and how they end when all is well:

{normal}
Whatever is blue in the picture can be broken off, and a machine may stop for good:

{broken}
One transition is taken a tick. Of the events of that tick the first in this order that the phase
knows is taken; one that it does not know changes nothing:

{events}

CHECKING is a test of these items in this order; the first that fails ends it:

{items}

TEACHING lets go of the head: a person pushes the catheter to the carina, confirms, and draws it
back or asks the drive to. OUT_OF_SERVICE drives nothing, not even a withdrawal: hands are in the
machine. A cycle starts only from PARKED, by a person or by the clock, and with a catheter whose
24 h last until its end.
"""


def table(transitions: Table) -> str:
    """A row for each pair of phases, with the events that lead from one to the other."""
    rows: dict[tuple[Phase, Phase], list[str]] = {}
    for (phase, event), following in transitions.items():
        rows.setdefault((phase, following), []).append(words(event.name))
    lines = [
        f"| {phase.name} | {', '.join(events)} | {following.name} |\n"
        for (phase, following), events in rows.items()
    ]
    return "| from | on | to |\n|---|---|---|\n" + "".join(lines)


def page() -> str:
    """The whole page."""
    return PAGE.format(
        normal=table(NORMAL),
        broken=table(BROKEN_OFF),
        events="\n".join(f"{event + 1}. {words(event.name)}" for event in Event),
        items="\n".join(f"{place}. {item.title}" for place, item in enumerate(ORDER, start=1)),
    )
