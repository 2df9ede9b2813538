"""A section by which a head is driven: each number is looked at, and refused in one line."""

from typing import Any

import numpy as np
import pytest

from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.kernel.errors import InputError
from opensuction.settings import calibration_section

GOOD = PlayLines(
    widths_mm=np.array([0.0, 18.0, 22.0]),
    lows_mm=np.array([0.0, 1.0, 2.0]),
    cell_mm=10.0,
    gains=np.array([[0.1, 0.1], [0.4, 0.45], [0.45, 0.4]]),
    decay_mm=30.0,
    lag=0.02,
    offset_mm=-6.0,
)
NAN = float("nan")
BAD: dict[str, dict[str, Any]] = {
    "driven has 2 widths_mm, 3 lows_mm and 3 lists in gains, should have as many of one as of the "
    "others, 1 to 64": {"widths_mm": [1.0, 2.0]},
    "driven has 0 widths_mm, 0 lows_mm and 0 lists in gains": {
        "widths_mm": [],
        "lows_mm": [],
        "gains": [],
    },
    "driven has 65 widths_mm, 65 lows_mm and 65 lists in gains": {
        "widths_mm": [1.0] * 65,
        "lows_mm": [1.0] * 65,
        "gains": [[1.0]] * 65,
    },
    "driven.gains has lists of 1 and 2 numbers, should have one number for each cell": {
        "gains": [[0.1], [0.4, 0.4], [0.5, 0.5]]
    },
    "driven.gains has lists of 0 numbers": {"gains": [[], [], []]},
    "driven.gains holds nan, should be a finite number": {
        "gains": [[0.1, NAN], [0.4, 0.4], [0.5, 0.5]]
    },
    "driven.lows_mm holds inf, should be a finite number": {"lows_mm": [0.0, 1.0, float("inf")]},
    "driven.widths_mm holds -1, none should be below 0": {"widths_mm": [-1.0, 18.0, 22.0]},
    "driven cannot drive a head: it is not monotone: a gain is -0.1, none should be below 0; "
    "identify again instead": {"gains": [[-0.1, 0.1], [0.4, 0.4], [0.5, 0.5]]},
    "driven cannot drive a head: it is not monotone: its slow state takes up to 0.2 from": {
        "lag": 0.1
    },
}


def test_a_model_comes_back_as_it_was_written() -> None:
    back = calibration_section.read(calibration_section.write(GOOD))
    for mine, theirs in zip(GOOD, back, strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("said", BAD)
def test_a_section_that_cannot_drive_is_refused_in_one_line(said: str) -> None:
    section = calibration_section.write(GOOD)._replace(**BAD[said])
    with pytest.raises(InputError) as caught:
        calibration_section.read(section)
    assert str(caught.value).startswith(said)
    assert "\n" not in str(caught.value)
