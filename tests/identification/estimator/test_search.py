import json
import random
import time
from pathlib import Path

import numpy as np
import pytest

from opensuction.hysteresis.catalogue.duhem_family import MODIFIED_DAHL_FORM as FORM
from opensuction.identification.estimator import modified_dahl
from opensuction.identification.estimator.linear import squares
from opensuction.identification.estimator.search import SEARCHES, search
from tests.identification.plant import drawn


def least_squares(seed: int, samples: int) -> float:
    """Sum of squares of variable projection, from the form's own simulation."""
    head_mm, tip_mm = drawn(seed, samples)
    found = modified_dahl.fit(head_mm, tip_mm)
    return squares(FORM, np.array([*found.model, found.lag_mm]), head_mm, tip_mm)


@pytest.mark.parametrize("method", SEARCHES)
def test_a_global_search_finds_what_projection_finds(method: str) -> None:
    head_mm, tip_mm = drawn(1, 400)
    found = squares(FORM, search(method, FORM, head_mm, tip_mm), head_mm, tip_mm)
    least = least_squares(1, 400)
    assert least <= found * (1.0 + 1e-9)
    assert found <= least * 1.01


@pytest.mark.parametrize("method", SEARCHES)
def test_a_search_repeats_itself_and_leaves_chance_as_it_was(method: str) -> None:
    head_mm, tip_mm = drawn(4, 150)
    random.seed(7)
    expected = random.Random(7).random()
    one = search(method, FORM, head_mm, tip_mm)
    assert random.random() == expected
    assert np.array_equal(one, search(method, FORM, head_mm, tip_mm))


@pytest.mark.soak
@pytest.mark.parametrize("method", SEARCHES)
def test_projection_is_never_worse_on_a_hundred_plants(method: str) -> None:
    """100 random plants with noise, 30,000 samples; figures to runs/soak."""
    excess, ratio = [], []
    modified_dahl.fit(*drawn(0, 30_000))
    for seed in range(100):
        head_mm, tip_mm = drawn(seed, 30_000)
        begin = time.process_time()
        modified_dahl.fit(head_mm, tip_mm)
        between = time.process_time()
        vector = search(method, FORM, head_mm, tip_mm)
        ratio.append((time.process_time() - between) / (between - begin))
        theirs = squares(FORM, vector, head_mm, tip_mm)
        excess.append(least_squares(seed, 30_000) / theirs - 1.0)
    result = {
        "method": method,
        "plants": len(excess),
        "excess": {"worst": max(excess), "least": min(excess), "median": float(np.median(excess))},
        "times_faster": {
            "least": min(ratio),
            "median": float(np.median(ratio)),
            "most": max(ratio),
        },
    }
    folder = Path("runs") / "soak"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"identification-{method}.json").write_text(json.dumps(result, indent=2) + "\n")
    assert max(excess) <= 1e-9
