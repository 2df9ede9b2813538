"""Friction that depends on speed: the lag that no rate-independent model follows."""

import numpy as np
import pytest

from opensuction.twin import parameter, preset, transmission_parameter
from opensuction.twin.conduit import play_line, rate_friction
from opensuction.twin.machine import transmission
from tests.twin.conduit.example import DT_S, strokes_mm

CLASS = play_line.RUBBING
VALUES = parameter.nominal(parameter.BENCH | transmission_parameter.rows(CLASS))
DRAWN = preset.transmission_of(VALUES, CLASS)
ROUNDING_MM = 1e-12
STILL = DRAWN._replace(creep=DRAWN.creep._replace(fast_mm=0.0, slow_mm=0.0))


def tip_at_mm(head_mm: float, speed_mm_per_s: float) -> float:
    """Tip once the head has come in from far out at a speed."""
    heads = strokes_mm(speed_mm_per_s, head_mm - 60.0, head_mm)
    start = transmission.after_retract(STILL, head_mm - 60.0)
    return float(transmission.simulate(STILL, start, heads, DT_S)[-1])


def test_the_lag_in_steady_motion_is_what_the_parameters_say() -> None:
    """Closed form: the tip is behind by g(v) times the gain, slower than at another speed."""
    slow, fast = 1.0, 15.0
    wanted = rate_friction.steady_mm(STILL.friction, slow)
    wanted -= rate_friction.steady_mm(STILL.friction, fast)
    behind = 50.0 - 0.5 * VALUES["bend_rad"] * VALUES["clearance_mm"] - 1.6
    slope = STILL.gain * (1.0 + STILL.gain_per_mm * (behind - STILL.middle_mm))
    # What the plays' spread leaves after 60 mm of travel is far below a micrometre.
    assert tip_at_mm(50.0, fast) - tip_at_mm(50.0, slow) == pytest.approx(slope * wanted, rel=1e-3)
    assert rate_friction.steady_mm(STILL.friction, 0.0) == VALUES["rub_static_mm"]


def test_a_catheter_that_stands_keeps_its_stretch() -> None:
    heads = strokes_mm(9.0, 0.0, 50.0)
    start = transmission.after_retract(STILL, 0.0)
    tips = transmission.simulate(STILL, start, np.append(heads, np.full(2000, 50.0)), DT_S)
    assert tips[-1] == tips[heads.size - 1]


def test_the_tip_never_moves_against_the_head_at_constant_speed() -> None:
    heads = strokes_mm(9.0, 0.0, 60.0, 10.0)
    start = transmission.after_retract(STILL, 0.0)
    tips = transmission.simulate(STILL, start, heads, DT_S)
    turn = int(np.argmax(heads))
    assert np.diff(tips[: turn + 1]).min() >= -ROUNDING_MM
    assert np.diff(tips[turn:]).max() <= ROUNDING_MM


def test_stretch_goes_with_what_is_laid_otherwise() -> None:
    wide = transmission.widen(STILL, 1.2)
    assert wide.lag_ratio == pytest.approx(1.2)
    start, wider = transmission.after_retract(STILL, 0.0), transmission.after_retract(wide, 0.0)
    gap = 0.5 * VALUES["bend_rad"] * VALUES["clearance_mm"] + VALUES["rub_static_mm"]
    assert wider.behind_mm - start.behind_mm == pytest.approx(0.2 * gap, rel=1e-9)
