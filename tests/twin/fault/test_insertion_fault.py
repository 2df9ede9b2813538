"""Each fault of catheter and insertion drive does to the machine what its row says."""

import numpy as np
import pytest

from opensuction.twin import preset
from opensuction.twin.fault.drive_fault import KINK_N
from opensuction.twin.fault.fault import Fault
from opensuction.twin.machine import machine, suction_line, transmission
from tests.twin.fault.broken_machine import HEALTHY, IDLE, PUSHING, faulty, parked, run
from tests.twin.holding import DT_S, hold_machine


def test_a_kink_narrows_the_bore_rubs_and_gives_way() -> None:
    """Turbulent flow goes with the bore to the power 19/7 (Blasius), mucus with its fourth."""
    kinked = faulty(Fault.CATHETER_KINKED, 0.5)
    flows = [suction_line.bore_flow_ml_per_s(m.line, 100.0, 1.0) for m in (kinked, HEALTHY)]
    assert flows[0] / flows[1] == pytest.approx(0.5 ** (19.0 / 7.0))
    uptakes = [m.airway.uptake_ml_per_s_per_mmhg for m in (kinked, HEALTHY)]
    assert uptakes[0] / uptakes[1] == pytest.approx(0.5**4)
    added_v = kinked.insertion_axis.friction_v - HEALTHY.insertion_axis.friction_v
    assert added_v == pytest.approx(0.5 * KINK_N * HEALTHY.load_v_per_n)
    moved = [
        transmission.step(m.transmission, parked().transmission, 20.0, DT_S).tip_mm
        for m in (kinked, HEALTHY)
    ]
    assert moved[0] < moved[1]


def test_a_jam_holds_the_head_and_raises_the_current() -> None:
    free = run(HEALTHY, parked(), PUSHING, 0.5)
    held = run(faulty(Fault.CATHETER_JAMMED, 8.0), parked(), PUSHING, 0.5)
    assert free.insertion.position > 3.0
    assert held.insertion.position == 0.0
    currents = [machine.read(HEALTHY, state).insertion_current_a for state in (held, free)]
    assert currents[0] > 5.0 * currents[1]
    most_a = HEALTHY.amperes_per_v * min(12.0, HEALTHY.insertion_axis.force_v)
    assert currents[0] == pytest.approx(most_a, abs=5.0 * HEALTHY.sensors.current.noise)


def test_a_jam_weaker_than_the_drive_only_slows_it() -> None:
    slowed = run(faulty(Fault.CATHETER_JAMMED, 1.0), parked(), PUSHING, 0.5)
    free = run(HEALTHY, parked(), PUSHING, 0.5)
    assert 0.0 < slowed.insertion.position < free.insertion.position


def test_another_route_of_the_conduit_has_another_gap() -> None:
    """Head travel from a turn until the last play has taken hold."""
    other = faulty(Fault.CONDUIT_REROUTED, 1.5)
    widths = np.divide(other.transmission.widths_mm, HEALTHY.transmission.widths_mm)
    np.testing.assert_allclose(widths, 1.5)
    assert other.transmission.stretch_mm == pytest.approx(1.5 * HEALTHY.transmission.stretch_mm)


def test_a_seized_motor_stops_where_it_is_and_draws_its_full_current() -> None:
    moving = run(HEALTHY, parked(), PUSHING, 0.3)
    seized = faulty(Fault.MOTOR_STALLED)
    at_once = hold_machine(seized, moving, PUSHING, 1)
    assert at_once.insertion.velocity == 0.0
    # It stops within the tick: less than a tick's way at full speed.
    assert abs(at_once.insertion.position - moving.insertion.position) < 0.02
    later = run(seized, at_once, PUSHING, 0.2)
    assert later.insertion.position == at_once.insertion.position
    assert later.insertion.drive_v == min(12.0, HEALTHY.insertion_axis.force_v)


def test_a_broken_winding_lets_the_motor_run_out() -> None:
    moving = run(HEALTHY, parked(), PUSHING, 0.3)
    later = run(faulty(Fault.MOTOR_LOST), moving, PUSHING, 0.5)
    assert later.insertion.velocity == 0.0
    assert later.insertion.drive_v == 0.0
    assert later.insertion.position > moving.insertion.position


def test_a_weak_drive_gives_less_force() -> None:
    weak = faulty(Fault.MOTOR_WEAK, 0.6)
    held = run(faulty(Fault.MOTOR_STALLED, twin=weak), parked(), PUSHING, 0.1)
    assert held.insertion.drive_v == pytest.approx(0.4 * HEALTHY.insertion_axis.force_v)


def test_swapped_wires_turn_the_motor_the_other_way() -> None:
    forth = run(HEALTHY, parked(), PUSHING, 0.3).insertion
    back = run(faulty(Fault.MOTOR_REVERSED), parked(), PUSHING, 0.3).insertion
    assert back.position == pytest.approx(-forth.position)
    assert back.drive_v == pytest.approx(-forth.drive_v)


def test_without_its_gear_the_head_stays_while_the_motor_turns() -> None:
    moving = run(HEALTHY, parked(), PUSHING, 0.3)
    later = run(faulty(Fault.GEAR_LOST), moving, PUSHING, 0.5)
    assert later.head_mm == moving.head_mm
    assert later.insertion.position > moving.insertion.position + 3.0
    seen = machine.read(HEALTHY, later)
    assert seen.head_mm - seen.carriage_mm > 3.0


def test_a_worn_gear_loses_more_at_each_turn() -> None:
    worn = faulty(Fault.GEAR_WORN, 4.0)
    forth = run(worn, parked(), PUSHING, 1.0)
    travelled = forth.insertion.position - parked().insertion.position
    lost = travelled - (forth.head_mm - parked().head_mm)
    # Parked after a retract: the whole play lies before it.
    assert lost == pytest.approx(worn.gear_backlash_mm, abs=4.0)
    assert lost > HEALTHY.gear_backlash_mm


def test_a_rack_ends_where_it_ends() -> None:
    ended = preset.limit_rack(HEALTHY, 0.0)
    pulled = run(ended, parked(), IDLE._replace(insertion_v=-24.0), 1.5)
    assert pulled.insertion.position == -preset.BEHIND_PARK_MM
    assert pulled.insertion.velocity == 0.0
