import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.interface import NO_REQUESTS
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState
from opensuction.twin import preset

HOUR_S = 3600.0


def parked() -> tuple[Loop, LoopState]:
    """A bedside machine, parked; the bench's protocol will do for standing still."""
    rig = rigs.rig("clinical", 1, nominal=True)
    calibration = rigs.uncalibrated(rig.profile)
    roomy = PAPER._replace(travel_mm=40.0, cap_mm=55.0, dwell_s=2.0)
    return rigs.assemble(rig, roomy, CompensationKind.NONE, calibration, 2)


@pytest.mark.parametrize("early", [0, 7])
def test_a_minute_passed_is_a_minute_of_the_closed_loop_at_rest(early: int) -> None:
    """To the last bit for patient and secretions: at rest they take the very same steps.

    Begun anywhere between two steps of the bedside.
    """
    loop, state = parked()
    state, _ = closed_loop.run(loop, state, NO_REQUESTS, trace.rows(1.0 + early * DT_S))
    played, _ = closed_loop.run(loop, state, NO_REQUESTS, trace.rows(60.0))
    passed = closed_loop.pass_time(loop, state, 60.0)
    assert passed.tick == played.tick
    assert str(passed.bedside) == str(played.bedside)
    assert np.array_equal(passed.bedside.secretion_ml, played.bedside.secretion_ml)
    assert passed.machine.coupling.ticks == played.machine.coupling.ticks == early
    assert passed.machine.coupling.signs == played.machine.coupling.signs
    assert passed.machine.line == played.machine.line
    # The polymer's creep is not followed.
    assert passed.machine.airway.tip_mm == pytest.approx(played.machine.airway.tip_mm, abs=0.3)


@pytest.mark.parametrize("hours", [3, pytest.param(24, marks=pytest.mark.soak)])
def test_the_secretions_of_hours_gather(hours: int) -> None:
    loop, state = parked()
    before = float(np.sum(state.bedside.secretion_ml))
    later = closed_loop.pass_time(loop, state, hours * HOUR_S)
    produced = float(np.sum(later.bedside.secretion_ml)) - before
    # 2 mL/h; the sum of 360,000 steps an hour is rounded.
    assert produced == pytest.approx(2.0 * hours, rel=1e-6)
    assert later.tick == state.tick + hours * 3_600_000
    assert 90.0 < later.machine.coupling.signs.spo2_percent < 100.0
    # A patient at rest stays as they are.
    drift = later.machine.coupling.signs.lung_volume_loss_ml
    assert abs(drift) < 1.0


def test_no_time_changes_nothing() -> None:
    loop, state = parked()
    assert str(closed_loop.pass_time(loop, state, 0.0)) == str(state)


def test_the_line_lets_its_vacuum_go_and_mucus_stays_in_the_bore() -> None:
    loop, state = parked()
    body = state.machine
    left = body._replace(
        line=body.line._replace(vacuum_mmhg=120.0), bore=body.bore._replace(mucus_ml=0.3)
    )
    later = closed_loop.pass_time(loop, state._replace(machine=left), HOUR_S)
    assert later.machine.line.vacuum_mmhg < 0.01
    assert later.machine.bore == left.bore


def test_the_worst_of_a_time_is_that_of_the_closed_loop_at_rest() -> None:
    """With too little oxygen: the saturation falls, late."""
    loop, state = parked()
    loop = loop._replace(machine=preset.ventilate(loop.machine, 0.15))
    rows = trace.rows(60.02)
    closed_loop.run(loop, state, NO_REQUESTS, rows)
    columns = trace.by_name(rows, ("truth.spo2_percent", "truth.lung_volume_loss_ml"))
    spo2, lost_ml = columns["truth.spo2_percent"], columns["truth.lung_volume_loss_ml"]
    found = closed_loop.find_worst(loop, state, 60.0)
    assert spo2.min() < spo2[0] - 1.0
    # A row shows the bedside's last step: what is found is a step ahead.
    assert spo2.min() <= found.spo2_percent <= spo2[:60_000].min()
    assert lost_ml[:60_000].max() <= found.lung_volume_loss_ml <= lost_ml.max()
