from pathlib import Path

from opensuction.procedure import diagram
from opensuction.procedure.cycle.transition import BROKEN_OFF, NORMAL, TRANSITIONS

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_page_in_the_documentation_is_the_generated_one() -> None:
    # Write it anew with: docs/phases.md = diagram.page()
    assert (DOCS / "phases.md").read_text(encoding="utf-8") == diagram.page()


def test_every_transition_is_drawn_once() -> None:
    arrows = [line for line in diagram.page().splitlines() if " --> " in line]
    drawn = [
        (line.split(" --> ")[0].strip(), event)
        for line in arrows
        for event in line.split(" : ")[1].split(", ")
    ]
    table = {(phase.name, event.name.lower().replace("_", " ")) for phase, event in TRANSITIONS}
    assert len(drawn) == len(table)
    assert set(drawn) == table


def test_the_two_halves_of_the_table_do_not_overlap() -> None:
    assert not NORMAL.keys() & BROKEN_OFF.keys()
    assert len(TRANSITIONS) == len(NORMAL) + len(BROKEN_OFF)
