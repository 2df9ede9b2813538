"""The clinical requirements of the paper's section II-A, held against plans."""

import pytest

from opensuction.kernel.vocabulary import AgeGroup
from opensuction.procedure.planning.guideline import GUIDELINES, SOURCES, Guideline, checks

ADULT = Guideline(
    vacuum_mmhg=120.0,
    negative_pressure_s=15.0,
    in_airway_s=25.0,
    catheter_ratio=4.0 / 8.5,
    speed_mm_per_s=10.0,
)


def failed(age: AgeGroup, planned: Guideline) -> list[str]:
    return [check.name for check in checks(age, planned) if not check.ok]


def test_the_usual_adult_cycle_meets_everything() -> None:
    assert failed(AgeGroup.ADULT, ADULT) == []


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"vacuum_mmhg": 151.0}, "vacuum"),
        ({"negative_pressure_s": 15.1}, "suction time"),
        ({"in_airway_s": 31.0}, "time in the airway"),
        (
            {"catheter_ratio": 4.0 / 7.5},
            "catheter over tube diameter",
        ),  # .533: the paper's own tube
        (
            {"catheter_ratio": 4.0 / 8.0},
            "catheter over tube diameter",
        ),  # not below half
        ({"speed_mm_per_s": 12.0}, "speed inwards"),
    ],
)
def test_each_limit_is_found_broken_alone(change: dict[str, float], name: str) -> None:
    assert failed(AgeGroup.ADULT, ADULT._replace(**change)) == [name]


def test_adult_suction_is_too_much_for_a_neonate() -> None:
    broken = failed(AgeGroup.NEONATE, ADULT._replace(catheter_ratio=4.0 / 3.5))
    assert {"vacuum", "suction time", "catheter over tube diameter"} <= set(broken)


def test_limits_tighten_with_age_and_every_one_has_a_source() -> None:
    adult, child, neonate = (
        GUIDELINES[age] for age in (AgeGroup.ADULT, AgeGroup.CHILD, AgeGroup.NEONATE)
    )
    assert neonate.vacuum_mmhg < child.vacuum_mmhg < adult.vacuum_mmhg
    assert child.negative_pressure_s == neonate.negative_pressure_s == 5.0
    assert set(SOURCES) == set(Guideline._fields)
