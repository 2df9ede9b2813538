"""Instant of a fault, and the time for which it cannot show, on a cycle made by hand."""

import numpy as np
import pytest

from opensuction.evidence.campaign import sound_machine
from opensuction.evidence.campaign.sound_machine import EDGE_S, HealthyCycle, Shows
from opensuction.kernel.vocabulary import Phase
from opensuction.simulation.closed_loop import DT_S

TICKS = 20_000
MOVING = np.zeros(TICKS, dtype=np.bool_)
MOVING[5000:8000] = True
MOVING[15_000:18_000] = True
"""The head goes in for 3 s, stands for 7 s, and comes out for 3 s."""
CYCLE = HealthyCycle(
    spans={
        "checking": (0.0, 5.0),
        "inserting": (5.0, 8.0),
        "suctioning": (8.0, 15.0),
        "withdrawing": (15.0, 18.0),
        "closing": (18.0, 20.0),
        "airway": (5.0, 17.0),
    },
    moving=MOVING,
    open=np.roll(MOVING, 2000),
)


@pytest.mark.parametrize(
    ("span", "share", "phase", "after_s"),
    [
        ("airway", 0.0, Phase.INSERTING, EDGE_S),
        ("airway", 0.5, Phase.SUCTIONING, 3.0),
        ("airway", 1.0, Phase.WITHDRAWING, 2.0 - EDGE_S),
        ("suctioning", 0.0, Phase.SUCTIONING, EDGE_S),
        ("suctioning", 1.0, Phase.SUCTIONING, 7.0 - EDGE_S),
        ("checking", 0.5, Phase.CHECKING, 2.5),
    ],
)
def test_an_instant_lies_in_its_span_and_names_its_phase(
    span: str, share: float, phase: Phase, after_s: float
) -> None:
    found = sound_machine.find_instant(CYCLE, span, share)
    assert found.phase == phase
    assert found.after_s == pytest.approx(after_s, abs=1e-9)


@pytest.mark.parametrize(
    ("at_s", "needed_s", "wait_s"),
    [
        (6.0, 1.0, 0.0),  # it moves for 2 s more
        (7.5, 1.0, 7.0),  # half a second, then 7 s of rest, then the other half
        (10.0, 1.0, 5.0),
        (16.0, 2.0, 0.0),
        (17.5, 1.0, 2.0),  # half a second is missing: it shows in nothing but the next cycle
        (19.0, 1.0, 1.0),
        (25.0, 1.0, 0.0),
    ],
)
def test_the_clock_of_a_fault_that_shows_in_motion_stands_still_with_the_head(
    at_s: float, needed_s: float, wait_s: float
) -> None:
    found = sound_machine.find_wait_s(CYCLE, Shows.MOVING, at_s, needed_s)
    assert found == pytest.approx(wait_s, abs=2 * DT_S)
    assert sound_machine.find_wait_s(CYCLE, Shows.ALWAYS, at_s, needed_s) == 0.0


def test_a_fault_of_the_open_valve_waits_for_the_valve() -> None:
    assert sound_machine.find_wait_s(CYCLE, Shows.OPEN, 6.0, 1.0) == pytest.approx(1.0, abs=0.002)
