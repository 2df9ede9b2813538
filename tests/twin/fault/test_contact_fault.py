"""Each fault of switch and tip does to the machine what its row says."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel import random_stream
from opensuction.twin.airway import airway
from opensuction.twin.fault.fault import Fault
from opensuction.twin.machine import tip_sensor, transmission
from opensuction.twin.machine.machine import Machine
from tests.twin.fault.broken_machine import HEALTHY, faulty
from tests.twin.holding import DT_S


def readings_of_the_switch(twin: Machine, forces_n: list[float]) -> list[bool]:
    state = tip_sensor.released(random_stream.stream(1, 1))
    seen = []
    for force_n in forces_n:
        state = tip_sensor.step(twin.switch, state, force_n, DT_S)
        seen.append(bool(state.reading))
    return seen


TOUCH = [0.0] * 100 + [0.2] * 200 + [0.0] * 200
"""Nothing, a firm touch, nothing."""


def test_a_switch_stuck_open_sees_no_touch() -> None:
    assert any(readings_of_the_switch(HEALTHY, TOUCH))
    assert not any(readings_of_the_switch(faulty(Fault.SWITCH_STUCK_OPEN), TOUCH))


def test_a_switch_stuck_closed_sees_one_everywhere() -> None:
    latency = math.ceil(HEALTHY.switch.latency_s / DT_S) + 1
    assert all(readings_of_the_switch(faulty(Fault.SWITCH_STUCK_CLOSED), TOUCH)[latency:])


@given(st.floats(0.05, 0.95))
def test_a_bridged_switch_is_closed_for_its_share_of_the_time(share: float) -> None:
    seen = readings_of_the_switch(faulty(Fault.SWITCH_BRIDGED, share), [0.0] * 1000)
    # Four standard deviations of a thousand draws.
    assert np.mean(seen) == pytest.approx(share, abs=4.0 * math.sqrt(share * (1.0 - share) / 1000))


def test_a_sticking_switch_does_not_open_again() -> None:
    seen = readings_of_the_switch(faulty(Fault.SWITCH_STICKING), TOUCH)
    assert not any(seen[:100])
    assert all(seen[-200:])


def test_a_bouncing_switch_chatters_for_its_time_and_then_rests() -> None:
    seen = readings_of_the_switch(faulty(Fault.SWITCH_BOUNCING, 0.1), TOUCH)
    latency = round(HEALTHY.switch.latency_s / DT_S)
    chatter, rest = seen[100 + latency : 200 + latency], seen[201 + latency : 300 + latency]
    assert 20 < sum(chatter) < 80  # half of the time
    assert all(rest)


def test_a_stiff_switch_needs_its_force() -> None:
    stiff = faulty(Fault.SWITCH_STIFF, 0.25)
    assert not any(readings_of_the_switch(stiff, [0.24] * 100))
    assert any(readings_of_the_switch(stiff, [0.25] * 100))


def test_a_late_switch_is_read_after_its_delay() -> None:
    seen = readings_of_the_switch(faulty(Fault.SWITCH_LATE, 0.05), TOUCH)
    assert not any(seen[:150])
    assert any(seen[150:160])


def force_n(twin: Machine, free_tip_mm: float) -> float:
    return float(airway.touch(twin.airway.tip, twin.airway.carina_mm, free_tip_mm).force_n)


def test_a_tip_that_misses_the_carina_meets_nothing_until_deeper() -> None:
    carina_mm = HEALTHY.airway.carina_mm
    missed = faulty(Fault.CARINA_MISSED, 40.0)
    assert force_n(HEALTHY, carina_mm + 0.5) > 0.0
    assert force_n(missed, carina_mm + 39.9) == 0.0
    assert force_n(missed, carina_mm + 40.5) == pytest.approx(force_n(HEALTHY, carina_mm + 0.5))


def test_a_displaced_tube_brings_the_carina_nearer() -> None:
    carina_mm = HEALTHY.airway.carina_mm
    assert force_n(faulty(Fault.TUBE_DISPLACED, 20.0), carina_mm - 19.0) > 0.0


@given(st.floats(0.0, 50.0))
def test_a_buckling_tip_never_presses_enough_to_close_the_switch(overlap_mm: float) -> None:
    soft = faulty(Fault.TIP_BUCKLING, 0.03)
    assert force_n(soft, soft.airway.carina_mm + overlap_mm) <= 0.03 < soft.switch.close_n


def test_a_detached_tip_leaves_a_shorter_catheter_without_a_switch() -> None:
    short = faulty(Fault.TIP_DETACHED, 5.0)
    behind_mm = 40.0
    whole_mm = transmission.depth_mm(HEALTHY.transmission, behind_mm)
    assert transmission.depth_mm(short.transmission, behind_mm) == pytest.approx(whole_mm - 5.0)
    assert not any(readings_of_the_switch(short, TOUCH))
