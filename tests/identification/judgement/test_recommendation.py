import numpy as np
import pytest

from opensuction.identification.judgement.recommendation import (
    Aim,
    Rated,
    check_purpose,
    recommend,
)
from opensuction.identification.record import Folds, Scores
from opensuction.kernel.errors import InputError

RANDOM = np.random.default_rng(8)
FOLDS = Folds(np.arange(0, 210, 10), np.arange(20) // 10, by_speed=False, reversals=(5, 5))


def rate(model: str, error: float, freedom: float, apart: float = 0.0) -> Rated:
    """A model whose blocks have about this squared error, and its parts `apart` or the same."""
    blocks = error * (1.0 + 0.1 * RANDOM.random(20))
    parts = blocks if apart == 0.0 else apart * (1.0 + 0.1 * RANDOM.random(20))
    return Rated(model, Scores(blocks, parts, 200), freedom, well_posed=model != "preisach")


DAHL = rate("modified-dahl", 4.0, 5.0)


def test_of_equals_the_simplest_is_taken_and_the_reason_says_so() -> None:
    plays = rate("prandtl-ishlinskii", 1.0, 9.0)
    noisy = plays.scores.blocks * np.where(np.arange(20) % 2, 1.09, 0.9)  # in all a bit better
    many = Rated("preisach", Scores(noisy, noisy, 200), 60.0, well_posed=True)
    found = recommend([many, DAHL, plays], Aim(), FOLDS)
    assert found.model == "prandtl-ishlinskii"
    assert "preisach has a smaller error in all, but not surely" in found.reasons[0]
    assert "it is simpler" in found.reasons[0]


def test_a_surely_better_model_is_taken_however_many_parameters_it_has() -> None:
    found = recommend([rate("preisach", 1.0, 60.0), DAHL], Aim(), FOLDS)
    assert found.model == "preisach"
    assert "every simpler model is surely worse" in found.reasons[0]
    assert found.errors["preisach"] < found.errors["modified-dahl"]


def test_none_is_recommended_that_does_worse_than_modified_dahl() -> None:
    """A simpler one within one standard error is still not taken."""
    blocks = DAHL.scores.blocks.copy()
    blocks[0] += 1.0
    blocks[1] -= 0.5
    simple = Rated("dahl", Scores(blocks, blocks, 200), 4.0, well_posed=True)
    found = recommend([simple, DAHL], Aim(), FOLDS)
    assert found.model == "modified-dahl"
    assert "dahl is simpler, but does worse" in found.reasons[0]


def test_what_cannot_drive_is_not_recommended_to_compensate_and_says_why() -> None:
    better = [
        rate("preisach", 1.0, 60.0)._replace(undriven="it is not monotone"),
        rate("bouc-wen", 2.0, 7.0)._replace(undriven="its inverse is a search"),
    ]
    found = recommend([*better, DAHL], Aim("compensate"), FOLDS)
    assert found.model == "modified-dahl"
    assert "the only one that can be used for it" in found.reasons[0]
    said = "bouc-wen predicts surely better, but drives no head: its inverse is a search."
    assert said in found.reasons
    assert any("preisach" in said and "not monotone" in said for said in found.reasons)
    with pytest.raises(InputError, match=r"no compensator takes any .*\(preisach, bouc"):
        recommend(better, Aim("compensate"), FOLDS)


def test_a_model_of_plays_that_drives_is_recommended_to_compensate() -> None:
    plays = rate("prandtl-ishlinskii", 1.0, 9.0)
    assert recommend([plays, DAHL], Aim("compensate"), FOLDS).model == "prandtl-ishlinskii"


def test_to_transfer_one_part_is_predicted_from_the_other() -> None:
    wild = rate("play-readout", 1.0, 40.0, apart=50.0)
    assert recommend([wild, DAHL], Aim("predict"), FOLDS).model == "play-readout"
    assert recommend([wild, DAHL], Aim("transfer"), FOLDS).model == "modified-dahl"


@pytest.mark.parametrize(
    ("purpose", "folds", "says"),
    [
        ("drive", FOLDS, "purpose 'drive' is not known: one of predict, compensate, transfer"),
        (
            "transfer",
            FOLDS._replace(reversals=(3, 1)),
            "first and second half of what is fitted hold 3 and 1 reversals, at least 2 each",
        ),
    ],
)
def test_a_purpose_without_enough_data_is_refused(purpose: str, folds: Folds, says: str) -> None:
    with pytest.raises(InputError, match=says) as refusal:
        check_purpose(purpose, folds)
    assert "\n" not in str(refusal.value)
    check_purpose("predict", folds)


SELDOM = FOLDS._replace(reversals=(1, 0))


def test_after_few_reversals_what_was_left_out_does_not_decide_alone() -> None:
    """Pieces left out of one stroke and back flatter what has most parameters."""
    plays = rate("play-readout", 0.5, 30.0)
    found = recommend([plays, DAHL], Aim(), SELDOM)
    assert found.model == "modified-dahl"
    assert "turns once, 3 times are needed" in found.reasons[0]
    assert recommend([plays, DAHL], Aim(), FOLDS).model == "play-readout"


def test_after_few_reversals_a_model_that_contains_modified_dahl_may_be_taken() -> None:
    residual = rate("residual-readout", 1.0, 90.0)
    assert recommend([residual, DAHL], Aim(), SELDOM).model == "residual-readout"
    halfway = SELDOM._replace(both_ways=0.6)
    assert recommend([residual, DAHL], Aim(), halfway).model == "modified-dahl"
    worse = rate("residual-readout", 5.0, 90.0)
    assert recommend([worse, DAHL], Aim(), SELDOM).model == "modified-dahl"
    bouc_wen = rate("bouc-wen", 1.0, 7.0)
    assert recommend([bouc_wen, DAHL], Aim(), halfway).model == "bouc-wen"
