"""Governor and patient: the catheter is withdrawn, or is not let in."""

from collections.abc import Callable

import pytest

from opensuction.kernel.interface import NO_MONITOR, Monitor, Readings, Setpoints
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.safety import limits
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode_trips
from opensuction.safety.governor import governor
from opensuction.safety.handling import Reaction
from tests.safety.watch.monitored import WELL
from tests.safety.watchdog import LIMITS, PARK_MM, Tick, first, run, sound, staying, tripped

MONITORED = LIMITS._replace(
    patient=limits.limits_of(AgeGroup.ADULT, 6.0, monitored=True),
    in_airway_s=60.0,
    negative_pressure_s=60.0,
    withdrawal_s=60.0,
)
INSIDE_MM = 60.0
OPENED_RAD = 0.5
WRONG = {
    Condition.SPO2_LOW: WELL._replace(spo2_percent=70.0),
    Condition.HEART_RATE_LOW: WELL._replace(heart_rate_per_min=30.0),
    Condition.AIRWAY_PRESSURE_UNSAFE: WELL._replace(airway_pressure_cmh2o=60.0),
    Condition.LUNG_VOLUME_LOST: WELL._replace(airway_pressure_cmh2o=-8.0),
    Condition.CIRCUIT_DISCONNECTED: WELL._replace(airway_pressure_cmh2o=0.9),
}


def reports(monitor: Callable[[float], Monitor], cam_rad: float = 0.0) -> Callable[..., Readings]:
    """A sound machine with this on its monitor."""

    def report(time_s: float, head_mm: float) -> Readings:
        return sound(head_mm)._replace(monitor=monitor(time_s), cam_rad=cam_rad)

    return report


def sucking(_time_s: float) -> Setpoints:
    return staying(INSIDE_MM)._replace(valve_open=True)


def inside(monitor: Callable[[float], Monitor], seconds: float) -> list[Tick]:
    """Suction in the airway, the head led out once the governor wants it."""
    start = governor.start(MONITORED, INSIDE_MM)
    return run(seconds, sucking, reports(monitor, OPENED_RAD), start, limits=MONITORED)


@pytest.mark.parametrize("code", WRONG)
def test_a_patient_in_danger_has_the_catheter_drawn_out_without_vacuum(code: Condition) -> None:
    # A saturation that leaps down is waited for; one that was low from the start is not.
    from_s = -1.0 if code == Condition.SPO2_LOW else 0.1
    ticks = inside(lambda s: WRONG[code] if s > from_s else WELL, 2.5)
    caught = first(ticks, code)
    assert caught.verdict.reaction == Reaction.WITHDRAW
    assert not caught.allowed.valve_open
    assert not caught.allowed.pump_on
    assert caught.allowed.vacuum_mmhg == 0.0
    assert caught.allowed.head_mm < INSIDE_MM
    # The cam here stays open whatever it is told.
    assert tripped(ticks) == {code, Condition.VALVE_STUCK_OPEN}
    # Held until a reset, although the patient is well again.
    better = run(
        0.1, sucking, reports(lambda _: WELL, OPENED_RAD), ticks[-1].state, limits=MONITORED
    )
    assert code in tripped(better)
    assert better[-1].verdict.reaction == Reaction.WITHDRAW


def test_a_pressure_lost_behind_a_closed_valve_is_no_doing_of_suction() -> None:
    low = reports(lambda _: WRONG[Condition.LUNG_VOLUME_LOST])
    start = governor.start(MONITORED, INSIDE_MM)
    ticks = run(0.4, lambda _: staying(INSIDE_MM), low, start, limits=MONITORED)
    assert tripped(ticks) == {Condition.AIRWAY_PRESSURE_UNSAFE}


@pytest.mark.parametrize("code", WRONG)
def test_with_the_catheter_out_it_is_shown_and_trips_nothing(code: Condition) -> None:
    # Lung volume is lost only while something sucks: then the valve is at fault, and nothing else.
    sucks = code == Condition.LUNG_VOLUME_LOST
    report = reports(lambda _: WRONG[code], OPENED_RAD if sucks else 0.0)
    ticks = run(2.5, lambda _: staying(PARK_MM), report, limits=MONITORED)
    assert tripped(ticks) == ({Condition.VALVE_STUCK_OPEN} if sucks else set())
    assert decode_trips(ticks[-1].verdict.patient) == [code]


def test_a_monitor_lost_inside_is_shown_and_ends_nothing() -> None:
    ticks = inside(lambda s: WELL if s < 0.1 else NO_MONITOR, 3.0)
    assert tripped(ticks) == set()
    assert decode_trips(ticks[-1].verdict.patient) == [Condition.MONITOR_LINK_LOST]
    assert ticks[-1].allowed.valve_open


def test_a_monitor_lost_outside_keeps_the_catheter_out() -> None:
    def inwards(time_s: float) -> Setpoints:
        return staying(PARK_MM + max(time_s - 2.1, 0.0) * 15.0)

    ticks = run(4.0, inwards, reports(lambda _: NO_MONITOR), limits=MONITORED)
    caught = first(ticks, Condition.MONITOR_LINK_LOST)
    assert caught.verdict.deepest_mm == pytest.approx(MONITORED.outside_mm, abs=0.1)
    assert ticks[-1].allowed.head_mm < caught.allowed.head_mm
    assert ticks[-1].verdict.deepest_mm <= caught.verdict.deepest_mm


def test_a_machine_without_a_monitor_misses_none() -> None:
    ticks = run(
        3.0, sucking, reports(lambda _: NO_MONITOR, OPENED_RAD), governor.start(LIMITS, -3.4)
    )
    assert Condition.MONITOR_LINK_LOST not in tripped(ticks)
    assert ticks[-1].verdict.patient == 0
