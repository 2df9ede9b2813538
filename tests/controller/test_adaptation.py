"""A calibration carried over to a gap that has changed: every model of it, in and out."""

import math

import numpy as np
import pytest

from opensuction.control import compensation
from opensuction.control.compensation import CompensationKind
from opensuction.control.motion_profile import HeadLimits
from opensuction.controller import calibration, setup
from opensuction.controller.calibration import PLAIN_PD, Calibration
from opensuction.controller.machine_profile import BENCH
from opensuction.evidence.benchmark import plant_run
from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis import prandtl_ishlinskii as pi
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.identification.estimator import modified_dahl as dahl_estimator
from opensuction.identification.estimator import prandtl_ishlinskii as play_estimator
from opensuction.identification.estimator.adaptation import Finding, unchanged
from opensuction.identification.estimator.gap_measurement import (
    AS_IDENTIFIED,
    TRUSTED,
    Array,
    Shift,
)
from opensuction.procedure.cycle import cycle
from opensuction.procedure.planning import planner
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S

KINDS = [kind for kind in CompensationKind if kind != CompensationKind.NONE]
PLANT = PrandtlIshlinskii(
    thresholds_mm=0.5 * np.array([15.0, 17.5, 19.0, 20.0, 21.0, 22.5, 25.0]),
    weights=np.array([0.05, 0.15, 0.2, 0.2, 0.2, 0.1, 0.067]),
    slope=0.0,
    offset_mm=-6.2,
    curvature_per_mm=0.0,
)
BARRIER_MM = 10.0
"""Depth of a barrier on the way of the bench's tip."""


def plant_mm(plant: PrandtlIshlinskii, head: Array) -> Array:
    return np.asarray(pi.simulate(plant, head, pi.retracted_positions_mm(plant, head[0])))


def identify(plant: PrandtlIshlinskii) -> Calibration:
    ticks = round(BENCH.excitation.duration_s / DT_S)
    head = np.array([cycle.excite(BENCH.excitation, tick * DT_S)[0] for tick in range(ticks)])
    tip = plant_mm(plant, head)
    found, plays = dahl_estimator.fit(head, tip), play_estimator.fit(head, tip)
    return rigs.calibrated(head, tip, found, plays, PLAIN_PD)


IDENTIFIED = identify(PLANT)


def paper_cycle(
    plant: PrandtlIshlinskii, kind: CompensationKind, used: Calibration
) -> tuple[Array, Array, float]:
    """Head, tip and tracking error of the paper's trapezoid on an ideal servo."""
    able = setup.abilities(BENCH, kind, used, BENCH_SITE)
    plan = planner.plan(PAPER, able, BENCH.excitation, False, BENCH_SITE)
    speeds = (PAPER.insertion_mm_per_s, PAPER.withdrawal_mm_per_s)
    chosen, heads_mm = setup.compensator(BENCH, kind, used, speeds), setup.branches(kind, used)
    course = plant_run.cycle_course(plan)
    limits = HeadLimits(BENCH.head_limit_mm_per_s, BENCH.acceleration_mm_per_s2)
    start = compensation.park(chosen, compensation.rest(chosen, heads_mm, BENCH_SITE.park_mm))
    heads = plant_run.lead(chosen, heads_mm, limits, start, course.demand, DT_S)
    heads = np.concatenate([[start.head_mm], heads])
    tip = plant_mm(plant, heads)
    error = (tip[1:] - course.demand[:, 0])[course.insertion_tick :]
    return heads, tip, math.sqrt(float(np.mean(error * error)))


@pytest.mark.parametrize("kind", KINDS)
def test_two_cycles_on_an_ideal_servo_bring_a_changed_gap_back(kind: CompensationKind) -> None:
    """Ten per cent of the gap and 2 mm: gone, but for what the compensator leaves anyway."""
    floor_mm = paper_cycle(PLANT, kind, IDENTIFIED)[2]
    changed = calibration.adapt_plays(PLANT, Shift(0.9, 2.0))
    used, change, errors_mm = IDENTIFIED, unchanged(TRUSTED), []
    for _ in range(3):
        heads, tip, rmse_mm = paper_cycle(changed, kind, used)
        errors_mm.append(rmse_mm)
        seen = calibration.passed(IDENTIFIED, tip <= BARRIER_MM, heads, BARRIER_MM, DT_S)
        change = calibration.learn(IDENTIFIED, change, seen)
        assert change.finding == Finding.LEARNED
        used = calibration.adapted(IDENTIFIED, change.new)
    assert change.new == pytest.approx(Shift(0.9, 2.0), abs=0.05)
    assert errors_mm[0] > floor_mm + 0.3
    # A gap that is narrower leaves less; the fits' own errors change by a tenth of a mm.
    assert errors_mm[2] < floor_mm + 0.1


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_every_model_is_shifted_alike(kind: CompensationKind, direction: float) -> None:
    """After a long way the head stands where the old middle and the scaled half put it."""
    shift = Shift(0.8, 1.5)

    def head_mm(used: Calibration, tip_mm: float, way: float) -> float:
        chosen, heads_mm = setup.compensator(BENCH, kind, used), setup.branches(kind, used)
        return compensation.head_after_travel_mm(chosen, heads_mm, tip_mm, way)

    there = 40.0
    before = [head_mm(IDENTIFIED, there - shift.offset_mm, way) for way in (1.0, -1.0)]
    middle, half = 0.5 * sum(before), 0.5 * (before[0] - before[1])
    adapted = calibration.adapted(IDENTIFIED, shift)
    assert head_mm(adapted, there, direction) == pytest.approx(
        middle + direction * shift.scale * half, abs=1e-6
    )


def test_an_unchanged_transmission_is_left_as_it_was_identified() -> None:
    same = calibration.adapted(IDENTIFIED, AS_IDENTIFIED)
    assert same.model == IDENTIFIED.model
    assert same.feedforward == IDENTIFIED.feedforward
    np.testing.assert_array_equal(same.plays.thresholds_mm, IDENTIFIED.plays.thresholds_mm)
    np.testing.assert_allclose(same.table.inwards_mm, IDENTIFIED.table.inwards_mm, atol=1e-12)


def test_the_modified_dahl_model_keeps_its_shape_over_another_gap() -> None:
    """Stretched in head travel: the same lag for the same share of the gap."""
    model = IDENTIFIED.model
    wider = calibration.adapt_dahl(model, Shift(1.2, 0.0))
    assert modified_dahl.gap_mm(wider) == pytest.approx(1.2 * modified_dahl.gap_mm(model))
    lag, far = 0.3 * modified_dahl.saturation_mm(model), 5.0
    assert modified_dahl.step(wider, 1.2 * lag, 1.2 * far) == pytest.approx(
        1.2 * modified_dahl.step(model, lag, far)
    )
