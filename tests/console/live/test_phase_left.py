"""Remaining time of a phase: by the plan, never negative, and absent where unknown."""

from functools import cache

import numpy as np
import pytest

from opensuction.console.live import row as live_row
from opensuction.console.live.row import PLACES, Row
from opensuction.controller.record import Settings
from opensuction.kernel.vocabulary import Phase
from opensuction.runtime.loop import ROW_COLUMNS
from tests.controller.bedside import at_bed

PROCEDURE = "state.core.procedure"


@cache
def settings() -> Settings:
    return at_bed("adult-icu")[0].controller


def row(phase: Phase, **procedure: float) -> Row:
    values = np.zeros(len(ROW_COLUMNS))
    values[PLACES["outputs.phase"]] = phase
    values[PLACES["inputs.dt_s"]] = 0.001
    for name, value in {"pace.ratio": 1.0, **procedure}.items():
        values[PLACES[f"{PROCEDURE}.{name.replace('__', '.')}"]] = value
    return Row(values)


@pytest.mark.parametrize("phase", [Phase.PARKED, Phase.HALTED, Phase.CHECKING, Phase.ABORTING])
def test_where_nobody_can_say_nothing_is_said(phase: Phase) -> None:
    assert live_row.left_s(settings(), row(phase)) is None


def test_an_insertion_counts_down_to_its_target() -> None:
    motion = settings().plan.motion
    whole = live_row.left_s(settings(), row(Phase.INSERTING, reference_mm=motion.park_mm))
    tube_s = -motion.park_mm / motion.tube_mm_per_s
    assert whole == pytest.approx(tube_s + motion.target_mm / motion.insertion_mm_per_s)
    there = live_row.left_s(settings(), row(Phase.INSERTING, reference_mm=motion.target_mm))
    assert there == 0.0


def test_by_contact_nobody_knows_when_it_will_touch() -> None:
    plan = settings().plan
    contact = plan.contact._replace(enabled=True)
    by_contact = settings()._replace(plan=plan._replace(contact=contact))
    assert live_row.left_s(by_contact, row(Phase.INSERTING)) is None


def test_suction_lasts_its_dwell_and_ends_sooner_where_nothing_comes() -> None:
    plan = settings().plan
    full = live_row.left_s(settings(), row(Phase.SUCTIONING, arrived_ticks=500.0))
    assert full == pytest.approx(plan.dwell_s - 0.5)
    quiet_ticks = 1e3 * (plan.pace.nothing_comes_s - 0.2)
    soon = live_row.left_s(
        settings(), row(Phase.SUCTIONING, arrived_ticks=500.0, pace__quiet_ticks=quiet_ticks)
    )
    assert soon == pytest.approx(min(0.2, plan.dwell_s - 0.5), abs=0.002)
    assert live_row.left_s(settings(), row(Phase.SUCTIONING, arrived_ticks=1e6)) == 0.0


def test_a_slower_way_out_takes_longer_but_no_longer_than_there_is_time_to_spare() -> None:
    def left_s(ratio: float, spare_s: float) -> float:
        made = row(Phase.WITHDRAWING, reference_mm=50.0, pace__ratio=ratio, pace__spare_s=spare_s)
        found = live_row.left_s(settings(), made)
        assert found is not None
        return found

    fast_s = left_s(1.0, 30.0)
    assert fast_s > 1.0
    assert left_s(0.5, 30.0) == pytest.approx(2.0 * fast_s)
    assert left_s(0.25, 2.0) == pytest.approx(fast_s + 2.0)
    assert left_s(0.25, 0.0) == pytest.approx(fast_s)
