"""The page on phases, made from the table of transitions."""

from opensuction.kernel.phase import Phase
from opensuction.procedure.cycle.check_item import ITEMS, ORDER
from opensuction.procedure.cycle.transition import ACTIVE, BROKEN_OFF, NORMAL, Event

Table = dict[tuple[Phase, Event], Phase]

PAGE = """# Phases

Generated from `opensuction.procedure.cycle.transition`: do not edit. A test compares the two.

One suction cycle, teaching and service, and how they end when all is well:

{normal}
What breaks off any of {active}, and what stops the machine for good:

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


def _words(event: Event) -> str:
    return event.name.lower().replace("_", " ")


def mermaid(table: Table) -> str:
    """A table of transitions in Mermaid's words, one arrow for each pair of phases."""
    arrows: dict[tuple[Phase, Phase], list[str]] = {}
    for (phase, event), following in table.items():
        arrows.setdefault((phase, following), []).append(_words(event))
    lines = [
        f"    {phase.name} --> {following.name} : {', '.join(events)}"
        for (phase, following), events in arrows.items()
    ]
    return "\n".join(["```mermaid", "stateDiagram-v2", *lines, "```", ""])


def page() -> str:
    """``docs/phases.md``."""
    return PAGE.format(
        normal=mermaid(NORMAL),
        active=", ".join(phase.name for phase in ACTIVE),
        broken=mermaid(BROKEN_OFF),
        events="\n".join(f"{event + 1}. {_words(event)}" for event in Event),
        items="\n".join(f"{place}. {ITEMS[item]}" for place, item in enumerate(ORDER, start=1)),
    )
