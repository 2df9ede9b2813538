"""The search for harm finds what is narrow, plays what it says, and says nothing else."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from opensuction.evidence.safety_case import hazard
from opensuction.evidence.safety_case.harm_search import EDGE_MS, STEP_MS, Play, beds_of, search
from opensuction.evidence.safety_case.hazard_case import Bed, Place, SearchedRun
from opensuction.evidence.safety_case.hazard_claim import Hazard
from opensuction.oracle.harm import ADVANCE, Harm
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.twin.fault.fault import Fault
from tests.evidence.safety_case.hazard_example import FAULT, ON_ONE, ROW

RUNS = 200
SEEDS = tuple(range(1, 9))
"""Machines and patients of the long search."""


WITH_STRENGTH = '[[hazard.fault]]\nname = "pump-weak"\nphases = ["all"]\n' + ON_ONE


def one_hazard(folder: Path, faults: str = FAULT + ON_ONE) -> Hazard:
    table = folder / "table.toml"
    table.write_text(ROW + faults)
    return hazard.load(table)[0]


PHASE_MS = 3000.0
"""How long a phase takes."""


def weak_spot(phase: str, at_ms: float, width_ms: float) -> Play:
    """A machine that is weak about one instant and at great strengths alone."""

    def play(_: Hazard, place: Place, beds: Sequence[Bed]) -> SearchedRun:
        off = (PHASE_MS * place.within + place.off_ms - at_ms) / width_ms
        worst = math.exp(-0.5 * off * off) * place.strength * (place.phase == phase)
        one = Injection(Fault.PUMP_WEAK, FaultInstant(None, 1.0), place.strength)
        breaches = (ADVANCE,) if worst > 0.95 else ()
        found = Harm(ADVANCE, worst, 1.0, "mm")
        return SearchedRun(beds[place.bed], one, found, worst, breaches, (), False)

    return play


@pytest.mark.parametrize("phase", ["preloading", "opening", "withdrawing"])
@pytest.mark.parametrize("off_ms", [-95, 20, 80])
def test_a_window_of_some_ten_milliseconds_is_found(
    tmp_path: Path, phase: str, off_ms: int
) -> None:
    one = one_hazard(tmp_path, WITH_STRENGTH)
    play = weak_spot(phase, off_ms, 20.0)
    found = [search(one, RUNS, (1, 2), seed, play) for seed in range(10)]
    assert sum(bool(each.broken) for each in found) >= 9


@pytest.mark.parametrize("at_ms", [400.0, 1500.0, 2900.0])
def test_so_is_an_instant_in_the_middle_of_a_phase(tmp_path: Path, at_ms: float) -> None:
    one = one_hazard(tmp_path, WITH_STRENGTH)
    play = weak_spot("inserting", at_ms, 300.0)
    found = [search(one, RUNS, (1, 2), seed, play) for seed in range(10)]
    assert sum(bool(each.broken) for each in found) >= 9


def test_it_goes_no_further_than_it_may(tmp_path: Path) -> None:
    places: list[Place] = []
    play = weak_spot("opening", EDGE_MS, 20.0)

    def look(one: Hazard, place: Place, beds: Sequence[Bed]) -> SearchedRun | None:
        places.append(place)
        return play(one, place, beds)

    found = search(one_hazard(tmp_path, WITH_STRENGTH), RUNS, (1,), 3, look)
    assert found.runs == len(places) == len(set(places)) <= RUNS
    assert all(abs(one.off_ms) <= EDGE_MS and one.off_ms % STEP_MS == 0 for one in places)
    assert all(0.0 <= one.strength <= 1.0 for one in places)
    inside = [one for one in places if one.within > 0.0]
    assert all(one.within < 1.0 and one.off_ms == 0 for one in inside)
    assert len(inside) > 0.1 * len(places)
    assert {1.0, 0.0} <= {one.strength for one in places}


def test_a_search_is_the_same_again_and_its_worst_run_too(tmp_path: Path) -> None:
    one = one_hazard(tmp_path)
    first, second = (search(one, 80, (1,)) for _ in range(2))
    assert first == second
    assert first.worst is not None
    assert first.broken == ()
    assert 0.0 < first.worst.share < 1.0
    assert first.worst.injection.fault == Fault.PUMP_RUNAWAY


def test_every_second_machine_is_drawn_twice_as_far(tmp_path: Path) -> None:
    beds = beds_of(one_hazard(tmp_path), (1, 2, 3))
    assert {(one.seed, one.spread) for one in beds} == {(1, 1.0), (2, 2.0), (3, 1.0)}
    found = search(one_hazard(tmp_path), 8, (1, 2))
    assert found.worst is not None
    wide = found.worst._replace(bed=found.worst.bed._replace(seed=2, spread=2.0))
    assert wide.title.endswith(", seed 2, spread 2")
    usual = found.worst._replace(bed=found.worst.bed._replace(seed=1, spread=1.0))
    assert usual.title.endswith(", seed 1")


def test_a_fault_of_the_set_up_is_searched_by_strength_and_bed(tmp_path: Path) -> None:
    """A depth that was taught too deep, on one patient: what it presses grows with it."""
    fault = '[[hazard.fault]]\nname = "taught-too-deep"\nphases = ["set-up"]\n' + ON_ONE
    found = search(one_hazard(tmp_path, fault), 5, (1,))
    assert found.worst is not None
    assert found.broken == ()
    assert 0.0 < found.worst.share < 1.0
    assert found.worst.title.startswith("taught-too-deep=")
    assert found.worst.injection.at == AT_START


@pytest.mark.soak
@pytest.mark.parametrize("one", hazard.load(), ids=lambda one: one.row.id)
def test_no_bound_is_broken_in_a_long_search(
    one: Hazard, record_property: Callable[[str, object], None]
) -> None:
    found = search(one, 5000, SEEDS, seed=11)
    worst = "none" if found.worst is None else f"{found.worst.share:.3f} {found.worst.title}"
    record_property("searched", f"{found.runs} runs, worst {worst}")
    assert [(each.title, each.breaches) for each in found.broken] == []
