"""Candidates for the paper's plant: docs/evidence/2026-11-24-paper-plant.md."""

from functools import cache

import pytest

from opensuction.evidence.paper import paper_plant
from opensuction.evidence.paper.paper_plant import (
    BOUC_WEN_RMSE_MM,
    CANDIDATES,
    RMSE_MM,
    SHOWN,
    Found,
    PlantCandidate,
)
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import PUBLISHED

ALIKE = BOUC_WEN_RMSE_MM / RMSE_MM


@cache
def judged(name: str, excitation: str = "stroke") -> Found:
    (one,) = (one for one in CANDIDATES if (one.name, one.excitation) == (name, excitation))
    return paper_plant.judge(one, one.solved)


@pytest.mark.parametrize("name", ["plays alone", "white noise", "creep of 5 s", "tip late"])
def test_a_candidate_has_the_paper_s_loop(name: str) -> None:
    """What it was solved for: gap, slope and the residual of modified Dahl."""
    found = judged(name)
    assert found.rmse_mm == pytest.approx(RMSE_MM, abs=1e-3)
    assert found.model.slope == pytest.approx(PUBLISHED.slope, abs=1e-3)
    gap_mm = float(modified_dahl.gap_mm(found.model))
    assert gap_mm == pytest.approx(modified_dahl.gap_mm(PUBLISHED), abs=0.05)


def test_a_late_tip_makes_bouc_wen_no_better_and_its_exponent_1() -> None:
    for name, most in (("plays alone", 0.05), ("white noise", 0.65), ("creep of 5 s", 0.3)):
        found = judged(name)
        assert found.bouc_wen_rmse_mm < most * RMSE_MM, name
    for name in ("tip late", "tip sluggish"):
        late = judged(name)
        assert late.bouc_wen_rmse_mm / late.rmse_mm == pytest.approx(ALIKE, abs=0.02)
        assert late.exponent == pytest.approx(1.0, abs=0.01)  # the paper's is 1.009
        # And yet it is not the paper's bench: the compensator leaves 2.44 mm there.
        assert late.after_mm > 2.7


def test_on_one_stroke_plays_have_the_paper_s_beta_and_on_a_cosine_they_have_the_twin_s() -> None:
    stroke = judged("plays alone")
    assert stroke.model.velocity_gain == pytest.approx(PUBLISHED.velocity_gain, abs=0.005)
    assert stroke.model.decay_per_mm == pytest.approx(PUBLISHED.decay_per_mm, abs=0.0005)
    assert stroke.after_mm == pytest.approx(2.44, abs=0.05)
    cosine = judged("plays alone", "cosine")
    assert cosine.model.velocity_gain < 0.78


def test_held_at_its_printed_shape_bouc_wen_is_no_better_on_the_twin_s_excitation() -> None:
    """D/(B + D) = .948 and m = 1.009, everything else fitted: .83 mm, where .02 mm can be had."""
    (plays, *_) = (one for one in CANDIDATES if one.excitation == "cosine")
    conduit = plays.solved._replace(spread_mm=plays.solved.amount)
    left_mm = paper_plant.fit_held_mm("cosine", conduit, {1: 0.948, 2: 1.009})
    assert left_mm == pytest.approx(RMSE_MM, abs=0.02)


@pytest.mark.soak
@pytest.mark.parametrize("candidate", CANDIDATES, ids=lambda one: f"{one.name}, {one.excitation}")
def test_the_numbers_of_a_candidate_are_those_that_are_found(candidate: PlantCandidate) -> None:
    found = paper_plant.solve(candidate)
    assert found == pytest.approx(candidate.solved, rel=0.03, abs=0.02)


def test_what_is_shown_is_one_excitation() -> None:
    assert {candidate.excitation for candidate in SHOWN} == {"stroke"}
    names = [(candidate.name, candidate.excitation) for candidate in CANDIDATES]
    assert len(set(names)) == len(names)
