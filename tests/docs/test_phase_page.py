from docs.generator import phase_page, phase_picture
from docs.generator.phase_picture import words
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import BROKEN_OFF, NORMAL, TRANSITIONS


def test_every_transition_has_its_place_in_a_table_once() -> None:
    lines = (line for line in phase_page.page().splitlines() if line.startswith("| "))
    rows = [line.strip("| ").split(" | ") for line in lines if "| from |" not in line]
    shown = [(row[0], event, row[2]) for row in rows for event in row[1].split(", ")]
    table = {
        (phase.name, words(event.name), following.name)
        for (phase, event), following in TRANSITIONS.items()
    }
    assert len([row for row in shown if row[1] != "on" and row[0] in Phase.__members__]) == len(
        table
    )
    assert table <= set(shown)


def test_the_picture_has_a_box_for_each_phase_and_every_normal_event() -> None:
    picture = phase_picture.svg()
    assert phase_picture.PLACES.keys() == set(Phase)
    assert len(set(phase_picture.PLACES.values())) == len(Phase)
    for phase in Phase:
        assert picture.count(f">{phase.name}<") == 1
    for _, event in NORMAL:
        count = sum(known == event for _, known in NORMAL)
        assert picture.count(f">{words(event.name)}<") == count


def test_no_arrow_runs_through_a_third_box() -> None:
    """On the grid: no box lies on the straight line between two others that are joined."""
    places = phase_picture.PLACES
    for one, other in phase_picture.arrows():
        (x1, y1), (x2, y2) = places[one], places[other]
        for phase, (x, y) in places.items():
            on_line = (x2 - x1) * (y - y1) == (y2 - y1) * (x - x1)
            between = min(x1, x2) <= x <= max(x1, x2) and min(y1, y2) <= y <= max(y1, y2)
            assert phase in (one, other) or not (on_line and between), (one, other, phase)


def test_the_two_halves_of_the_table_do_not_overlap() -> None:
    assert not NORMAL.keys() & BROKEN_OFF.keys()
    assert len(TRANSITIONS) == len(NORMAL) + len(BROKEN_OFF)
