"""A hand teaches the travel length: physically, within limits, and with a hand's error."""

from functools import cache

import numpy as np
import pytest

from opensuction.kernel.interface import ABORT, HOME, NO_REQUESTS, START, TEACH
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.teaching import Taught
from opensuction.simulation import closed_loop, self_calibration, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.rig import Rig
from opensuction.simulation.self_calibration import Teaching
from opensuction.simulation.trace import Columns
from tests.columns_of_rows import ColumnsOfRows


@cache
def rig(seed: int, patient: str = "adult-icu") -> tuple[Rig, rigs.Identification]:
    chosen = rigs.rig("clinical", seed, patient=patient)
    return chosen, rigs.identify(chosen)


@cache
def taught(seed: int, patient: str = "adult-icu") -> Teaching:
    chosen, identified = rig(seed, patient)
    return self_calibration.teach(chosen, identified.calibration, COLUMNS)


def run(loop: Loop, state: LoopState, pressed: dict[float, object]) -> Columns:
    """Pieces of a run, each beginning with what was pressed."""
    parts = []
    ends = [*list(pressed)[1:], list(pressed)[-1] + 30.0]
    for (begin_s, requests), end_s in zip(pressed.items(), ends, strict=True):
        table = trace.rows(end_s - begin_s)
        state, ticks = closed_loop.run(loop, state, requests, table)  # type: ignore[arg-type]
        parts.append(table[:ticks])
    return ColumnsOfRows(np.concatenate(parts))


@pytest.mark.parametrize(
    ("seed", "patient"), [(1, "adult-icu"), (2, "adult-icu"), (1, "child-10kg"), (1, "neonate")]
)
def test_a_hand_teaches_a_little_too_deep(seed: int, patient: str) -> None:
    found = taught(seed, patient)
    assert found.taught == Taught.TAKEN
    assert found.home
    # It presses for its reaction time (2 mm at 8 mm/s); the model is 1 mm off this plant.
    assert 0.5 <= found.taught_mm - rig(seed, patient)[0].machine.airway.carina_mm <= 5.0


def test_who_is_slow_to_confirm_teaches_too() -> None:
    chosen, identified = rig(51_040)
    loop, _ = self_calibration.assemble(chosen, identified.calibration)
    assert loop.machine.hand.confirm_s > 0.29
    assert self_calibration.teach(chosen, identified.calibration).taught == Taught.TAKEN


def test_the_hand_moves_the_head_as_a_hand_can() -> None:
    columns = taught(1).columns
    assert [int(phase) for phase in dict.fromkeys(columns["phase"])] == [
        Phase.TEACHING,
        Phase.PARKED,
    ]
    during = columns["phase"] == Phase.TEACHING
    assert not columns["commands.insertion_on"][during].any()
    assert not columns["commands.insertion_v"][during].any()
    assert not columns["commands.pump_on"].any()
    assert columns["truth.valve_open_ratio"].max() == 0.0
    speed = np.diff(columns["truth.head_mm"]) / DT_S
    assert np.abs(speed).max() < 45.0
    assert not columns["verdict.trips"].any()
    inside = columns["verdict.deepest_mm"] > -80.0
    assert np.count_nonzero(inside) * DT_S < 30.0
    assert np.count_nonzero(columns["truth.contact_n"] > 0.0) * DT_S < 2.0


def test_the_same_person_teaches_the_same_and_another_another() -> None:
    chosen, identified = rig(1)
    again = self_calibration.teach(chosen, identified.calibration)
    assert again.taught_mm == taught(1).taught_mm
    assert taught(2).taught_mm != taught(1).taught_mm


def test_no_cycle_starts_under_the_plan_that_teaches() -> None:
    chosen, identified = rig(1)
    loop, state = self_calibration.assemble(chosen, identified.calibration)
    columns = run(loop, state, {0.0: START})
    assert set(columns["phase"]) == {Phase.PARKED}


@pytest.mark.parametrize("request_name", ["abort", "home"])
def test_the_drive_takes_the_catheter_out_of_the_hand(request_name: str) -> None:
    chosen, identified = rig(1)
    loop, state = self_calibration.assemble(chosen, identified.calibration)
    asked = ABORT if request_name == "abort" else HOME
    columns = run(loop, state, {0.0: TEACH, 8.0: asked})
    last = Phase.HALTED if request_name == "abort" else Phase.PARKED
    assert columns["phase"][-1] == last
    park_mm = loop.controller.plan.motion.park_head_mm
    assert columns["readings.head_mm"][-1] == pytest.approx(park_mm, abs=0.75)
    after = columns["time_s"] > 8.2
    assert np.diff(columns["truth.tip_mm"][after]).max() < 1e-3
    speed = np.abs(np.diff(columns["commands.head_mm"][after])) / DT_S
    if request_name == "home":
        assert speed.max() <= 10.0 + 1e-6
    assert not columns["verdict.trips"].any()


def test_a_hand_that_finds_no_carina_loses_the_catheter_to_the_governor() -> None:
    chosen, identified = rig(1)
    loop, state = self_calibration.assemble(chosen, identified.calibration)
    airway = loop.machine.airway._replace(carina_mm=1000.0)
    loop = loop._replace(machine=loop.machine._replace(airway=airway))
    columns = run(loop, state, {0.0: TEACH, 25.0: NO_REQUESTS})
    assert columns["verdict.trips"].any()
    assert columns["phase"][-1] == Phase.HALTED
    assert columns["truth.tip_mm"].max() <= loop.controller.limits.cap_mm
