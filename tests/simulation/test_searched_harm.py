"""Runs in which the search for harm broke a bound, and none is broken any more."""

import pytest

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import JUDGED, Played
from opensuction.evidence.campaign.sound_machine import Kind, SoundMachine
from opensuction.evidence.safety_case.hazard_case import COMPENSATION
from opensuction.oracle import exposure
from opensuction.oracle.exposure import PatientExposure
from opensuction.simulation.injection import invariant
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.twin.fault.fault import Fault


def play(
    kind: Kind, seed: int, spread: float, fault: Fault, at_s: float, strength: float
) -> tuple[SoundMachine, Played, PatientExposure]:
    """A fault at an instant of the cycle of a drawn machine and patient."""
    room = played_cycle.make_room(JUDGED)
    prepared = sound_machine.prepare(kind, seed, COMPENSATION, spread=spread)
    machine = sound_machine.play(prepared, room)
    one = Injection(fault, FaultInstant(None, at_s), strength)
    played = played_cycle.play_faulty(machine, (one,), seed, room)
    return machine, played, exposure.measure(prepared.rig.machine, played.run.columns)


@pytest.mark.parametrize(
    ("fault", "kind", "seed", "at_s", "strength"),
    [
        (Fault.CONDUIT_REROUTED, Kind("adult-icu", "contact"), 6, 18.388, 3.0),
        (Fault.CONDUIT_REROUTED, Kind("child-10kg", "contact"), 2, 10.617, 3.0),
        (Fault.CONDUIT_REROUTED, Kind("neonate", "travel"), 6, 8.234, 3.0),
        (Fault.HEAD_SENSORS_DRIFTING, Kind("adult-ards", "contact"), 6, 18.252, -2.81004),
    ],
    ids=str,
)
def test_no_tip_stays_where_the_barrier_sees_it_with_its_head_home(
    fault: Fault, kind: Kind, seed: int, at_s: float, strength: float
) -> None:
    """Three times the gap, and two sensors that drift together: up to 1.1 mm short of out."""
    machine, played, borne = play(kind, seed, 2.0, fault, at_s, strength)
    assert borne.end_mm < borne.outside_mm - 1.0
    # The rack ends ten millimetres behind home.
    park_mm = machine.prepared.loop.controller.limits.park_head_mm
    assert played.run.columns["truth.head_mm"].min() > park_mm - 7.0


@pytest.mark.requirement("OS-R03")
def test_the_valve_does_not_open_on_a_carina_that_was_lifted_to_the_tip() -> None:
    """While the vacuum was built; it opened, and the tip followed the carina as that sank."""
    kind = Kind("adult-ards", "travel")
    _, played, borne = play(kind, 7, 1.0, Fault.TUBE_DISPLACED, 13.77, 25.5064)
    assert borne.advance_mm == 0.0
    lifted = played.run.columns["truth.contact_n"] > 0.0
    assert lifted.any()
    assert played.run.columns["truth.tip_vacuum_mmhg"][lifted].max() == 0.0


@pytest.mark.parametrize(
    ("fault", "kind", "seed", "spread", "at_s", "strength"),
    [
        (Fault.ENCODER_INTERMITTENT, Kind("child-10kg", "contact"), 3, 1.0, 0.08, 0.001),
        (Fault.ENCODER_ALTERNATING, Kind("neonate", "travel"), 4, 2.0, 2.072, -17.8452),
        (Fault.ENCODER_OFFSET, Kind("adult-ards", "travel"), 7, 1.0, 2.09, -50.0),
    ],
    ids=str,
)
def test_the_relief_valve_is_tested_in_no_tick_that_does_not_read_the_head_at_home(
    fault: Fault, kind: Kind, seed: int, spread: float, at_s: float, strength: float
) -> None:
    machine, played, _ = play(kind, seed, spread, fault, at_s, strength)
    assert not invariant.command_side(played.run.sent, machine.prepared.loop.controller)


@pytest.mark.requirement("OS-R03")
@pytest.mark.parametrize(
    ("at_s", "strength"), [(20.275, 29.222), (20.577, 26.4), (19.322, 47.4), (19.397, 37.31)]
)
def test_the_valve_closes_on_a_carina_that_is_lifted_to_the_tip(
    at_s: float, strength: float
) -> None:
    """The tip followed it by .51 to .56 mm under vacuum, in the dwell and on the way out."""
    kind = Kind("adult-icu", "contact")
    _, played, borne = play(kind, 8, 2.0, Fault.TUBE_DISPLACED, at_s, strength)
    assert borne.advance_mm < 0.49
    columns = played.run.columns
    touched_s = columns["time_s"][(columns["truth.contact_n"] > 0.0) & (columns["time_s"] > at_s)]
    assert touched_s[0] - at_s < 0.01
    late = columns["time_s"] > touched_s[0] + 0.8
    assert columns["truth.tip_vacuum_mmhg"][late].max() == 0.0


@pytest.mark.parametrize("strength", [0.09, 0.106, 0.12, 0.14])
@pytest.mark.parametrize("after_s", [0.1, 0.6])
def test_a_slit_of_the_valve_draws_nothing_or_shows_before_a_child_s_way_in_is_over(
    strength: float, after_s: float
) -> None:
    """Of 15 mmHg it drew for the whole way, 63.5 mm, and nobody was told."""
    kind, seed = Kind("child-10kg", "contact"), 8
    prepared = sound_machine.prepare(kind, seed, COMPENSATION, spread=3.0)
    room = played_cycle.make_room(JUDGED)
    machine = sound_machine.play(prepared, room)
    at_s = round(machine.healthy.spans["inserting"][0] + after_s, 3)
    one = Injection(Fault.VALVE_STUCK_OPEN, FaultInstant(None, at_s), strength)
    played = played_cycle.play_faulty(machine, (one,), seed, room)
    assert played.judge().breaches == ()
    borne = exposure.measure(prepared.rig.machine, played.run.columns)
    assert borne.advance_mm < 51.0
