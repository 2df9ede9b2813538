"""The search for harm finds what is narrow, plays what it says, and says nothing else."""

import math
from collections.abc import Sequence
from pathlib import Path

import pytest

from opensuction.evidence.safety_case import harm_search, hazard
from opensuction.evidence.safety_case.harm_search import (
    EDGE_MS,
    STEP_MS,
    Bed,
    Place,
    SearchedRun,
    search,
)
from opensuction.evidence.safety_case.hazard_claim import Hazard
from opensuction.oracle.harm import ADVANCE, Harm
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault
from tests.evidence.safety_case.hazard_example import FAULT, ON_ONE, ROW

RUNS = 200


def one_hazard(folder: Path, faults: str = FAULT + ON_ONE) -> Hazard:
    table = folder / "table.toml"
    table.write_text(ROW + faults)
    return hazard.load(table)[0]


def weak_spot(phase: str, off_ms: int, width_ms: float) -> harm_search.Play:
    """A machine that is weak about one instant and at great strengths alone."""

    def play(_: Hazard, place: Place, beds: Sequence[Bed]) -> SearchedRun:
        off = (place.off_ms - off_ms) / width_ms
        worst = math.exp(-0.5 * off * off) * place.strength * (place.phase == phase)
        one = Injection(Fault.PUMP_RUNAWAY, FaultInstant(None, 1.0), place.strength)
        breaches = (ADVANCE,) if worst > 0.95 else ()
        return SearchedRun(beds[place.bed], one, Harm(ADVANCE, worst, 1.0, "mm"), breaches, False)

    return play


@pytest.mark.parametrize("phase", ["preloading", "opening", "withdrawing"])
@pytest.mark.parametrize("off_ms", [-95, 20, 80])
def test_a_window_of_some_ten_milliseconds_is_found(
    tmp_path: Path, phase: str, off_ms: int
) -> None:
    one = one_hazard(tmp_path)
    play = weak_spot(phase, off_ms, 20.0)
    found = [search(one, RUNS, (1, 2), seed, play) for seed in range(10)]
    assert sum(bool(each.broken) for each in found) >= 9


def test_it_goes_no_further_than_it_may(tmp_path: Path) -> None:
    places: list[Place] = []
    play = weak_spot("opening", EDGE_MS, 20.0)

    def look(one: Hazard, place: Place, beds: Sequence[Bed]) -> SearchedRun | None:
        places.append(place)
        return play(one, place, beds)

    found = search(one_hazard(tmp_path), RUNS, (1,), 3, look)
    assert found.runs == len(places) == len(set(places)) <= RUNS
    assert all(abs(one.off_ms) <= EDGE_MS and one.off_ms % STEP_MS == 0 for one in places)
    assert all(0.0 <= one.strength <= 1.0 for one in places)
    assert {1.0, 0.0} <= {one.strength for one in places}


def test_a_search_is_the_same_again_and_its_worst_run_too(tmp_path: Path) -> None:
    one = one_hazard(tmp_path)
    first, second = (search(one, 8, (1,)) for _ in range(2))
    assert first == second
    assert first.worst is not None
    assert first.broken == ()
    assert 0.0 < first.worst.share < 1.0
    assert first.worst.injection.fault == Fault.PUMP_RUNAWAY


def test_what_is_there_before_the_start_is_not_searched(tmp_path: Path) -> None:
    fault = '[[hazard.fault]]\nname = "taught-too-deep"\nphases = ["set-up"]\n'
    assert search(one_hazard(tmp_path, fault), RUNS, (1,)) == harm_search.HarmSearch(0, None, ())
