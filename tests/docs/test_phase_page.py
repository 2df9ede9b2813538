from docs.generator import phase_page
from opensuction.procedure.cycle.transition import BROKEN_OFF, NORMAL, TRANSITIONS


def test_every_transition_is_drawn_once() -> None:
    arrows = [line for line in phase_page.page().splitlines() if " --> " in line]
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
