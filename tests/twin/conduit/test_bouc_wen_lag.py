"""The twin's Bouc-Wen lag against the catalogue's solution of the same equation."""

import numpy as np
import pytest

from opensuction.hysteresis import bouc_wen
from opensuction.twin import parameter, preset, transmission_parameter
from opensuction.twin.conduit import play_line, rate_friction
from opensuction.twin.machine import transmission
from tests.twin.conduit.example import DT_S, strokes_mm

CLASS = play_line.BOUC_WEN
VALUES = parameter.nominal(parameter.BENCH | transmission_parameter.rows(CLASS))
DRAWN = preset.transmission_of(VALUES, CLASS)
STILL = DRAWN._replace(creep=DRAWN.creep._replace(fast_mm=0.0, slow_mm=0.0))


def test_the_papers_parameters_give_the_papers_model() -> None:
    heads = strokes_mm(9.0, 0.0, 40.0, 20.0, 21.0, 19.5, 60.0, 0.0)
    tips = transmission.simulate(STILL, transmission.after_retract(STILL, 0.0), heads, DT_S)
    model = bouc_wen.PUBLISHED
    memory = -bouc_wen.saturation_mm(model)
    whole = bouc_wen.simulate(model, np.append(0.0, heads), memory)[1:]
    # Two solvers of one equation; a step of .009 mm in which the memory comes home crosses a kink.
    assert np.max(np.abs(tips - whole)) < 1e-5


@pytest.mark.parametrize("ratio", [0.5, 1.5])
def test_a_wider_loop_is_the_same_loop_larger(ratio: float) -> None:
    wide = transmission.widen(STILL, ratio)
    heads = strokes_mm(9.0, 0.0, 3.0, 2.0, 6.0)
    tips = transmission.simulate(STILL, transmission.after_retract(STILL, 0.0), heads, DT_S)
    start = transmission.after_retract(wide, 0.0)
    wider = transmission.simulate(wide, start, ratio * heads, DT_S)
    # Both axes of the lag are scaled, and the line behind it is straight.
    offset = STILL.offset_mm
    assert wider - offset == pytest.approx(ratio * (tips - offset), abs=1e-9)


def test_a_long_move_is_the_short_ones_of_which_it_consists() -> None:
    lag = STILL.bouc_wen
    memory = 0.3
    for _ in range(200):
        memory = rate_friction.step_bouc_wen_lag(lag, memory, -0.02)
    assert rate_friction.step_bouc_wen_lag(lag, 0.3, -4.0) == pytest.approx(memory, abs=1e-6)
    assert rate_friction.step_bouc_wen_lag(lag, 0.3, 0.0) == 0.3
