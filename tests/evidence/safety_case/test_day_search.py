"""The search over days finds a rare patient, judges by the truth and says what it played."""

import math

import pytest

from opensuction.evidence.campaign.sound_machine import Kind
from opensuction.evidence.safety_case import day_search
from opensuction.evidence.safety_case.day_search import (
    MOST_SPREAD,
    CycleHarm,
    DayPlace,
    DaySearch,
    Play,
    SearchedDay,
    find_share,
    search,
    summarise,
)
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.oracle import exposure
from opensuction.oracle.harm import (
    ADVANCE,
    FORCE,
    LEFT_INSIDE,
    LUNG_VOLUME,
    SATURATION,
    SUCTION_TIME,
    TIP_PAST_CAP,
    Harm,
)
from opensuction.report.safety_case.safety_case_page import describe_days

ADULT = Kind("adult-icu", "contact")


def a_day(place: DayPlace, worst_ml: float) -> SearchedDay:
    one = CycleHarm(3, Harm(LUNG_VOLUME, worst_ml, 550.0, "mL"), told=False)
    broken = (one,) if one.bound.is_broken else ()
    return SearchedDay(place, 30, 1, one, find_share(one.bound), broken)


def frail_far_off(seeds: int) -> Play:
    """One machine in some loses volume with how far it is drawn, and calibration adds to it."""

    def play(place: DayPlace) -> SearchedDay:
        frail = place.seed // 8 % seeds == 1
        worst_ml = 150.0 * place.spread * frail + 120.0 * place.self_calibrates
        return a_day(place, worst_ml)

    return play


def test_a_frail_patient_is_followed_to_where_the_bound_breaks() -> None:
    found = [search(ADULT, 100, seed, frail_far_off(7)) for seed in range(10)]
    worst = [one.worst for one in found if one.broken]
    assert len(worst) >= 9
    for day in worst:
        assert day is not None
        assert day.share == math.inf
        assert day.place.self_calibrates
        assert day.place.spread > 2.8


def test_no_day_is_played_twice_and_none_lies_beyond_three_deviations() -> None:
    places: list[DayPlace] = []

    def play(place: DayPlace) -> SearchedDay:
        places.append(place)
        return a_day(place, 20.0 * place.spread)

    found = search(ADULT, 200, play_day=play)
    assert len(places) == len(set(places)) == len(found.days)
    assert all(0.0 <= place.spread <= MOST_SPREAD for place in places)
    assert {place.self_calibrates for place in places} == {True, False}
    anew = places[: int(0.4 * 200)]
    assert len({place.seed for place in anew}) == len(anew)
    assert {place.spread for place in anew} == {1.0, 2.0, 3.0}


def test_kinds_share_no_seed() -> None:
    seen: dict[int, Kind] = {}
    for kind in (ADULT, Kind("neonate", "travel"), Kind("adult-icu", "travel")):
        for day in search(kind, 10, play_day=lambda place: a_day(place, 1.0)).days:
            assert seen.setdefault(day.place.seed, kind) == kind


def test_machines_that_cannot_do_it_are_counted() -> None:
    def play(place: DayPlace) -> SearchedDay | None:
        return None if place.spread > 2.0 else a_day(place, 1.0)

    found = search(ADULT, 30, play_day=play)
    assert found.refused >= 4
    assert found.refused + len(found.days) == 30


@pytest.mark.parametrize(
    ("bound", "share"),
    [
        (Harm(FORCE, 0.15, 0.3, "N"), 0.5),
        (Harm(ADVANCE, 0.0, 0.5, "mm"), 0.0),
        (Harm(SATURATION, 95.0, 90.0, "%"), 0.5),
        (Harm(SATURATION, 89.9, 90.0, "%"), math.inf),
        (Harm(LEFT_INSIDE, -90.0, -80.0, "mm"), 0.0),
        (Harm(TIP_PAST_CAP, 59.0, 59.8, "mm"), 0.0),
        (Harm(TIP_PAST_CAP, 59.9, 59.8, "mm"), math.inf),
        (Harm(LEFT_INSIDE, -70.0, -80.0, "mm"), math.inf),
        (Harm(LUNG_VOLUME, -3.0, 550.0, "mL"), 0.0),
    ],
)
def test_the_share_is_of_the_way_to_the_bound(bound: Harm, share: float) -> None:
    assert find_share(bound) == pytest.approx(share)


@pytest.mark.parametrize("calibrates", [pytest.param(False, marks=pytest.mark.sweep), True])
def test_a_day_is_judged_cycle_by_cycle(monkeypatch: pytest.MonkeyPatch, calibrates: bool) -> None:
    monkeypatch.setattr(day_search, "CYCLES", 2)
    place = DayPlace(ADULT, calibrates, 7, 1.0)
    found = day_search.play(place)
    assert found is not None
    assert (found.cycles, found.aborted, found.broken) == (2, 0, ())
    assert 0.0 < found.share < 1.0
    # With less suction allowed than any cycle needs, each of the two breaks that bound alone.
    adult = exposure.BOUNDS[AgeGroup.ADULT]
    monkeypatch.setitem(exposure.BOUNDS, AgeGroup.ADULT, adult._replace(suction_s=0.5))
    found = day_search.play(place)
    assert found is not None
    assert [one.cycle for one in found.broken] == [1, 2]
    assert {one.bound.name for one in found.broken} == {SUCTION_TIME}
    assert found.share == math.inf


def test_the_summary_says_what_to_type_and_what_broke() -> None:
    place = DayPlace(ADULT, True, 12, 2.5)
    fine, bad = a_day(place, 275.0), a_day(place._replace(seed=20), 642.0)
    found = summarise(DaySearch((fine, bad), 1))
    assert (found.days, found.cycles, found.aborted, found.refused) == (2, 60, 2, 1)
    assert (found.broken, found.untold) == (1, 1)
    (problem,) = found.problems
    assert problem.command == (
        "cycle --patient adult-icu --approach contact --seed 20 --spread 2.5 --repeat 30 "
        "--every 30 --self-calibrate"
    )
    assert (problem.worst, problem.limit, problem.share) == (642.0, 550.0, None)
    assert problem.broken == (LUNG_VOLUME,)
    assert describe_days(found).endswith("a bound broken in 1, untold in 1.")
    held = summarise(DaySearch((fine,), 0))
    assert held.worst is not None
    assert held.worst.share == 0.5
    assert describe_days(held).endswith("no bound broken, nearest lung-volume at 50 %.")
    nothing = summarise(DaySearch((), 0))
    assert (nothing.worst, nothing.problems) == (None, ())
