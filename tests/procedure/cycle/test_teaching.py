import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.procedure.cycle import teaching
from opensuction.procedure.cycle.teaching import PLAUSIBLE, SENTENCES, Taught, TeachingState
from opensuction.procedure.planning import guideline

ADULT = PLAUSIBLE[AgeGroup.ADULT]


def confirmed(tip_mm: float, readable: bool = True) -> TeachingState:
    begun = teaching.UNTAUGHT
    return teaching.step(ADULT, begun, True, False, readable, 100.0, False, tip_mm)


@pytest.mark.requirement("OS-R27")
@given(st.floats(-200.0, 400.0))
def test_only_a_plausible_length_is_taken(tip_mm: float) -> None:
    found = confirmed(tip_mm)
    if 30.0 <= tip_mm <= 100.0:
        assert (found.taught, found.taught_mm) == (Taught.TAKEN, tip_mm)
    else:
        assert found.taught == (Taught.TOO_SHORT if tip_mm < 30.0 else Taught.TOO_DEEP)
        assert found.taught_mm == 0.0


def test_a_dead_encoder_teaches_nothing() -> None:
    found = confirmed(60.0, readable=False)
    assert (found.taught, found.taught_mm) == (Taught.HEAD_UNREAD, 0.0)


def test_it_ends_only_after_the_head_was_away_and_has_rested_at_home() -> None:
    def over(state: TeachingState) -> bool:
        return bool(teaching.is_over(state, 0.001))

    resting = teaching.UNTAUGHT
    for _ in range(1000):
        resting = teaching.step(ADULT, resting, False, False, True, 0.1, True, 0.0)
    assert not over(resting)
    away = teaching.step(ADULT, resting, False, False, True, 6.0, False, 0.0)
    ticks = 0
    while not over(away):
        away = teaching.step(ADULT, away, False, False, True, 0.1, True, 0.0)
        ticks += 1
    assert ticks == pytest.approx(teaching.RETURNED_S / 0.001, abs=1)
    sent = teaching.step(ADULT, resting, False, True, True, 0.1, True, 0.0)
    assert over(sent)


@pytest.mark.parametrize(
    ("age", "taught_mm", "message"),
    [
        (
            AgeGroup.ADULT,
            150.0,
            "--taught 150 mm is 50 mm beyond the most plausible for adult, 100 mm: measure again "
            "from the tube's lower end to the carina, 30 to 100 mm",
        ),
        (
            AgeGroup.ADULT,
            float("nan"),
            "--taught nan mm is no length: measure from the tube's lower end to the carina, 30 to "
            "100 mm",
        ),
        (
            AgeGroup.NEONATE,
            2.5,
            "--taught 2.5 mm is 2.5 mm short of the least plausible for neonate, 5 mm: measure "
            "again from the tube's lower end to the carina, 5 to 25 mm",
        ),
    ],
)
def test_a_length_outside_is_refused_with_its_arithmetic(
    age: AgeGroup, taught_mm: float, message: str
) -> None:
    with pytest.raises(InputError) as refused:
        guideline.check_plausible(age, taught_mm, "--taught")
    assert str(refused.value) == message


@pytest.mark.parametrize("nonsense", [float("nan"), float("inf"), -1.0])
def test_nonsense_is_refused_too(nonsense: float) -> None:
    with pytest.raises(InputError):
        guideline.check_plausible(AgeGroup.ADULT, nonsense, "--taught")


def test_every_age_and_every_code_has_its_entry() -> None:
    assert set(PLAUSIBLE) == set(AgeGroup)
    assert set(SENTENCES) == set(Taught)
