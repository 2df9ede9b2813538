"""The page on phases in the documentation, drawn from the table of transitions."""

from opensuction.kernel.phase import Phase
from opensuction.procedure.transition import ACTIVE, BROKEN_OFF, NORMAL, Event

Table = dict[tuple[Phase, Event], Phase]

PAGE = """# Phases

Generated from `opensuction.procedure.transition`: do not edit. A test compares the two.

One suction cycle and how it ends when all is well:

{normal}
What breaks off any of {active}, and what stops the machine for good:

{broken}
One transition is taken a tick. Of the events of that tick the first in this order that the phase
knows is taken; one that it does not know changes nothing:

{events}
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
    )
