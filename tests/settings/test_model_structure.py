"""Models put together again from the parameters of a file."""

from typing import Any

import numpy as np
import pytest

from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.preisach import Preisach
from opensuction.kernel.errors import InputError
from opensuction.settings import model_structure
from opensuction.settings.model_structure import FittedPart, Structure

X = np.concatenate([np.linspace(0.0, 100.0, 50), np.linspace(100.0, 10.0, 50)])
WEIGHTS = np.array([[20.0, 10.0, 30.0], [5.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
RECORD = Preisach(-2.0, 102.0, WEIGHTS, 3.0)
VALUES = {
    "cell_0_0": 20.0,
    "cell_0_1": 10.0,
    "cell_0_2": 30.0,
    "cell_1_0": 5.0,
    "cell_2_0": 2.0,
    "offset": 3.0,
}
PART = FittedPart("head_mm", X, RECORD, -1.0, None)
(STRUCTURE,) = model_structure.describe("preisach", [PART], VALUES)


def test_factors_that_were_left_out_are_0() -> None:
    (part,) = model_structure.rebuild("preisach", VALUES, [STRUCTURE])
    model = CATALOGUE["preisach"]
    expected = model.simulate(RECORD, X, model.memory(RECORD, 0.0, -1.0))
    assert np.array_equal(part.simulate(X), expected)


def test_a_force_keeps_the_offset_that_its_record_has_not() -> None:
    values = {"stiffness": 2.0, "limit": 10.0, "offset": 5.0, "initial_output": 0.0}
    (part,) = model_structure.rebuild("dahl", values, [])
    assert part.offset == pytest.approx(5.0)
    assert part.simulate(np.zeros(2)) == pytest.approx([5.0, 5.0])


BAD: dict[str, tuple[Any, str]] = {
    "unknown model": (("presach", VALUES, [STRUCTURE]), "did you mean 'preisach'?"),
    "one that nothing identifies": (("play", {}, []), "one that no recording identifies"),
    "no structure": (("preisach", VALUES, []), "written by an older version; identify again"),
    "surplus": (
        ("preisach", VALUES | {"cell_9_9": 1.0}, [STRUCTURE]),
        "unknown key parameters.cell_9_9",
    ),
    "surplus of a vector": (("dahl", {"slope": 1.0}, []), "unknown key parameters.slope"),
    "missing": (("dahl", {"stiffness": 1.0}, []), "parameters.limit is missing"),
    "no model": (
        ("dahl", {"stiffness": -1.0, "limit": 1.0, "offset": 0.0, "initial_output": 0.0}, []),
        "make no 'dahl' model",
    ),
    "elements": (
        ("preisach", VALUES, [STRUCTURE._replace(elements={"low_mm": 0.0})]),
        "structure.elements.high_mm is missing",
    ),
    "sizes": (("preisach", VALUES, [STRUCTURE._replace(sizes={})]), "structure.sizes.weights_mm"),
    "dimensions": (
        ("preisach", VALUES, [STRUCTURE._replace(sizes={"weights_mm": [9], "offset_mm": []})]),
        "structure.sizes.weights_mm has 1 dimensions, should have 2",
    ),
    "huge": (
        (
            "preisach",
            VALUES,
            [STRUCTURE._replace(sizes={"weights_mm": [10**9, 10**9], "offset_mm": []})],
        ),
        "lengths of at most 100000 factors",
    ),
    "memory": (
        ("preisach", VALUES, [STRUCTURE._replace(memory=[1.0])]),
        "structure.memory has 1 numbers, the model's has shape (3,)",
    ),
    "turned": (
        ("preisach", VALUES, [STRUCTURE._replace(highest=-1.0)]),
        "should be above structure.lowest",
    ),
    "other elements": (
        (
            "preisach",
            VALUES,
            [STRUCTURE._replace(elements={"low_mm": 5.0, "high_mm": 1.0})],
        ),
        "make no 'preisach' model",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_makes_no_model_is_refused_in_a_line(case: str) -> None:
    given, words = BAD[case]
    with pytest.raises(InputError) as raised:
        model_structure.rebuild(*given)
    assert words in str(raised.value)
    assert len(str(raised.value).splitlines()) == 1


def test_a_structure_is_plain_data() -> None:
    assert (
        Structure(
            column="head_mm",
            memory_ratio=-1.0,
            lowest=0.0,
            highest=100.0,
            elements={"low_mm": -2.0, "high_mm": 102.0},
            sizes={"weights_mm": [3, 3], "offset_mm": []},
            memory=[],
            beside=[],
        )
        == STRUCTURE
    )


def test_a_memory_that_is_more_than_a_ratio_is_kept() -> None:
    memory = np.array([5.0, -3.0, 20.0])
    told = VALUES | {"extra": 1.0}
    (one,) = model_structure.describe("preisach", [PART._replace(memory=memory)], told)
    assert one.beside == ["extra"]
    (part,) = model_structure.rebuild("preisach", told, [one])
    expected = CATALOGUE["preisach"].simulate(RECORD, X, memory)
    assert np.array_equal(part.simulate(X), expected)
    assert not np.array_equal(part._replace(memory=None).simulate(X), expected)


def test_a_searched_model_has_no_structure() -> None:
    assert model_structure.describe("modified-dahl", [], ["slope"]) == ()
