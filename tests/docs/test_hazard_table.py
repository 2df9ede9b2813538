"""The walk through the machine leaves nothing out."""

from docs.generator import hazard_table
from opensuction.evidence.safety_case import hazard


def test_every_part_answers_every_guide_word_and_nothing_else() -> None:
    for part in hazard_table.walk():
        assert set(part) == {"name", *hazard_table.GUIDE_WORDS}, part["name"]


def test_the_walk_names_known_hazards_and_every_one_of_them() -> None:
    known = {one.row.id for one in hazard.load()}
    named = {
        name
        for part in hazard_table.walk()
        for key in hazard_table.GUIDE_WORDS
        if isinstance(part[key], list)
        for name in part[key]
    }
    assert named == known
