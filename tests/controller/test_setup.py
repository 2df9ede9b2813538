import math

import pytest

from opensuction.control.compensation import FED_FORWARD, LOOKS_AHEAD, CompensationKind
from opensuction.controller import setup
from opensuction.controller.calibration import PLAIN_PD, Calibration, Feedforward, assume_nominal
from opensuction.controller.machine_profile import BENCH
from opensuction.controller.record import Settings
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER, Protocol
from opensuction.safety import limits as safety_limits

FOUND = assume_nominal(PUBLISHED, Feedforward(velocity_v_s_per_mm=1.28, friction_v=0.5))


def settings(protocol: Protocol, kind: CompensationKind, calibration: Calibration) -> Settings:
    return setup.settings(BENCH, protocol, kind, calibration, by_contact=False, site=BENCH_SITE)


every_kind = pytest.mark.parametrize("kind", CompensationKind)


@every_kind
def test_the_parked_tip_counts_as_outside_and_the_target_as_inside(kind: CompensationKind) -> None:
    made = settings(PAPER, kind, FOUND)
    limits = made.limits
    parked = safety_limits.assume_anywhere(limits.tip, made.parked.head_mm)
    assert safety_limits.deepest_mm(limits.tip, parked) == pytest.approx(limits.outside_mm - 1.0)
    assert (
        safety_limits.deepest_mm(limits.tip, safety_limits.follow(limits.tip, parked, 90.0)) > 60.0
    )
    assert made.plan.motion.park_head_mm == limits.park_head_mm == made.parked.head_mm


@every_kind
def test_the_target_lies_below_the_head_s_cap(kind: CompensationKind) -> None:
    made = settings(PAPER, kind, FOUND)
    cap = safety_limits.head_cap_mm(made.limits.tip, made.limits.cap_mm)
    needed = 90.0
    if kind != CompensationKind.NONE:
        needed = (90.0 + modified_dahl.saturation_mm(PUBLISHED) - PUBLISHED.offset_mm) / 0.9677
    assert needed < cap


def test_a_cap_that_would_stop_the_head_short_is_refused_with_what_would_do() -> None:
    wide = PUBLISHED._replace(decay_per_mm=0.04)
    calibration = FOUND._replace(model=wide)
    with pytest.raises(InputError) as caught:
        settings(PAPER, CompensationKind.EXACT_INVERSE, calibration)
    assert str(caught.value) == (
        "cap_mm 95 mm allows the head 121.0 mm in case the gap of 42.7 mm has shrunk, and "
        "travel_mm 90 mm needs 122.5 mm: set cap_mm to 96.4 mm or more"
    )
    enough = PAPER._replace(cap_mm=96.5)
    settings(enough, CompensationKind.EXACT_INVERSE, calibration)
    settings(PAPER, CompensationKind.NONE, calibration)


def test_the_papers_schemes_get_the_papers_servo() -> None:
    for kind in set(CompensationKind) - set(FED_FORWARD):
        servo = settings(PAPER, kind, FOUND).insertion_servo
        assert (servo.proportional_v, servo.derivative_v_s) == (10.0, 0.010)
        assert (servo.velocity_v_s, servo.friction_v, servo.time_constant_s) == (0.0, 0.0, 0.0)
    for kind in FED_FORWARD:
        servo = settings(PAPER, kind, FOUND).insertion_servo
        assert (servo.velocity_v_s, servo.friction_v) == (1.28, 0.5)


def test_only_the_kinds_that_look_ahead_cross_the_gap_ahead_of_time() -> None:
    for kind in CompensationKind:
        plan = settings(PAPER, kind, FOUND).plan
        crosses = kind in LOOKS_AHEAD
        assert (plan.preload_s > 0.0) == crosses
        assert (plan.gap_lead_s > 0.0) == crosses


def test_a_forced_withdrawal_has_time_from_the_deepest_point() -> None:
    limits = settings(PAPER, CompensationKind.NONE, FOUND).limits
    deepest_head = safety_limits.head_cap_mm(limits.tip, limits.cap_mm)
    slowest_s = (deepest_head - limits.park_head_mm) / BENCH.head_planned_mm_per_s
    assert slowest_s + 2.0 < limits.withdrawal_s < slowest_s + 5.0


def test_an_uncalibrated_machine_is_bounded_by_its_nominal_transmission() -> None:
    calibration = assume_nominal(BENCH.transmission, PLAIN_PD)
    limits = settings(PAPER, CompensationKind.NONE, calibration).limits
    gap = modified_dahl.gap_mm(PUBLISHED)
    assert limits.tip == safety_limits.bound_tip(PUBLISHED.slope, PUBLISHED.offset_mm, gap)


@every_kind
def test_no_limit_is_missing(kind: CompensationKind) -> None:
    limits = settings(PAPER, kind, FOUND).limits
    # By travel nothing says where contact must come, nor, on the bench, where it may not.
    groups = (limits.drive, limits.valve, limits.line)
    assert not limits.patient.monitored  # nobody is there
    # Nor is there a tube's mouth with a light barrier.
    assert limits.mouth_mm == math.inf
    # Nor anybody whom a driven tip must not touch.
    assert limits.driven_contact_s == math.inf
    there = limits._replace(mouth_mm=0.0, driven_contact_s=0.0)
    values = [value for value in there if isinstance(value, float)]
    for value in [*values, *(value for group in groups for value in group)]:
        assert math.isfinite(value)
    assert limits.negative_pressure_s == PAPER.negative_pressure_budget_s
    assert limits.in_airway_s == PAPER.in_airway_budget_s
    assert limits.stalled_mm < BENCH.settle_mm
