"""Sensors that part from each other, and from the motor."""

import pytest

from opensuction.safety.head import head_vote
from opensuction.safety.watch import head_watch
from tests.safety.watchdog import above

STILL_MM = head_watch.ADRIFT_MM
MOVING_MM = STILL_MM + 10.0 * head_watch.MODEL_LAG_S
"""The motor at 10 mm/s, either way: a tenth of a millimetre more."""


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("motor_mm_per_s", "encoder_mm", "carriage_mm", "adrift"),
    [
        (0.0, above(STILL_MM), above(STILL_MM), True),
        (0.0, STILL_MM, above(STILL_MM), False),
        (0.0, above(STILL_MM), STILL_MM, False),
        (0.0, 1.0, -1.0, False),  # they part from each other: that is another trip
        (10.0, 0.31, 0.31, True),
        (-10.0, 0.31, 0.31, True),
        (10.0, MOVING_MM, MOVING_MM, False),
        (-10.0, MOVING_MM, MOVING_MM, False),
    ],
)
def test_both_are_adrift_that_run_from_the_motor_together(
    sign: float, motor_mm_per_s: float, encoder_mm: float, carriage_mm: float, adrift: bool
) -> None:
    vote = head_vote.start(50.0, read=True)._replace(
        motor_mm_per_s=motor_mm_per_s,
        encoder_lead_mm=sign * encoder_mm,
        carriage_lead_mm=sign * carriage_mm,
    )
    assert head_watch.is_adrift(vote) == adrift
    assert pytest.approx(0.3) == MOVING_MM
