"""Models with their numbers, called in one form whichever they are."""

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from opensuction.hysteresis import CATALOGUE, Model, model
from opensuction.kernel.errors import InputError

CASES: dict[str, dict[str, Any]] = {
    "modified-dahl": {
        "slope": 0.95,
        "velocity_gain": 0.4,
        "decay_per_mm": 0.08,
        "offset_mm": -6.0,
    },
    "dahl": {"stiffness_n_per_mm": 0.15, "coulomb_n": 1.0},
    "play": {"width_mm": 10.0, "gain": 0.9, "offset_mm": 1.0},
    "prandtl-ishlinskii": {
        "thresholds_mm": [2.0, 4.0],
        "weights": [0.3, 0.2],
        "slope": 0.4,
        "offset_mm": 1.0,
        "curvature_per_mm": 0.0,
    },
    "preisach": {
        "low_mm": 0.0,
        "high_mm": 100.0,
        "weights_mm": np.full((4, 4), 6.0),
        "offset_mm": 0.0,
    },
}
X = np.concatenate([np.linspace(5.0, 60.0, 30), np.linspace(60.0, 20.0, 30)])


@pytest.mark.parametrize("name", CASES)
def test_every_model_is_simulated_and_inverted_by_the_same_call(name: str) -> None:
    made = model(name, **CASES[name])
    y = made.simulate(X, past=-1.0, start=0.0)
    assert y.shape == X.shape
    # A force is the same again for any input beyond saturation: a range that is not there.
    inside = np.abs(y) < 0.99 if name == "dahl" else np.full(X.size, True)
    if inside.all():
        again = made.inverse(y, past=-1.0, start=0.0, jumps=True)
        assert made.simulate(again, past=-1.0, start=0.0) == pytest.approx(y, abs=1e-8)
    assert made.entry is CATALOGUE[name]


def test_the_past_shifts_a_play_by_its_width() -> None:
    made = model("play", width_mm=2.0, gain=1.0, offset_mm=0.0)
    assert made.simulate([0.0], past=-1.0) - made.simulate([0.0], past=1.0) == pytest.approx([2.0])


def test_an_offset_is_added_to_a_force() -> None:
    made = model("dahl", **CASES["dahl"])
    lifted = Model("dahl", made.record, offset=5.0)
    assert lifted.simulate(X) == pytest.approx(made.simulate(X) + 5.0)
    assert lifted.inverse([4.5, 5.5]) == pytest.approx(made.inverse([-0.5, 0.5]))
    assert "offset=5" in repr(lifted)


REFUSED: dict[str, tuple[Any, str]] = {
    "name": (lambda: model("dhal"), "model 'dhal' is not known: one of modified-dahl"),
    "nothing": (lambda: model("play"), "given nothing, should be width_mm, gain, offset_mm"),
    "surplus": (lambda: model("play", width=1.0), "given width, should be width_mm"),
    "text": (
        lambda: model("play", width_mm="a", gain=1.0, offset_mm=0.0),
        "width_mm is no number",
    ),
    "shape": (
        lambda: model("play", width_mm=[1.0], gain=1.0, offset_mm=0.0),
        "width_mm has shape (1,), should be one number",
    ),
    "ill-posed": (
        lambda: model("play", width_mm=-1.0, gain=1.0, offset_mm=0.0),
        "not well posed",
    ),
    "past": (
        lambda: model("play", **CASES["play"]).simulate(X, past=2.0),
        "past: 2, should be from -1",
    ),
    "input": (lambda: model("play", **CASES["play"]).simulate([np.nan]), "sample 0 is nan"),
    "jump": (lambda: model("play", **CASES["play"]).inverse([1.0]), "no continuous inverse"),
    "beyond": (
        lambda: model("dahl", **CASES["dahl"]).inverse([0.0, 2.0]),
        "y: sample 1 is 2, which no input of model 'dahl' reaches (1 such of 2)",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_refused_in_a_line(case: str) -> None:
    call, words = REFUSED[case]
    with pytest.raises(InputError) as raised:
        call()
    assert words in str(raised.value)


def test_it_is_shown_in_a_line() -> None:
    assert repr(model("play", **CASES["play"])) == "Model(play, width_mm=10, gain=0.9, offset_mm=1)"
    assert "weights_mm=<16 numbers>" in repr(model("preisach", **CASES["preisach"]))


ORDERS = {
    "the library first": "import opensuction as osn; osn.hysteresis.model; "
    "import opensuction.hysteresis as room; from opensuction.hysteresis import play",
    "the room first": "import opensuction.hysteresis as room; import opensuction as osn",
    "a module of the room first": "from opensuction.hysteresis import play; "
    "import opensuction as osn; import opensuction.hysteresis as room",
}


@pytest.mark.parametrize("order", ORDERS)
def test_the_room_is_the_same_whichever_is_imported_first(order: str) -> None:
    program = (
        f"{ORDERS[order]}; assert osn.hysteresis is room; "
        "print(osn.hysteresis.model('play', width_mm=2.0, gain=1.0, offset_mm=0.0)"
        ".simulate([0.0, 3.0]))"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        capture_output=True,
        text=True,
        env={"NUMBA_DISABLE_JIT": "1"},
        check=True,
    )
    assert done.stdout == "[1. 2.]\n"
