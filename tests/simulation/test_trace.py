import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import COLUMNS


def test_phase_spans_follow_one_another_without_a_gap() -> None:
    columns = {
        "phase": np.array([0.0, 1.0, 1.0, 3.0, 3.0, 3.0]),
        "time_s": np.arange(6) * 0.001,
    }
    spans = trace.phase_spans(columns)
    assert [span.phase for span in spans] == [Phase.PARKED, Phase.CHECKING, Phase.INSERTING]
    assert [span.start_s for span in spans] == pytest.approx([0.0, 0.001, 0.003])
    assert [span.end_s for span in spans] == pytest.approx([0.001, 0.003, 0.006])


def test_by_name_gives_each_column() -> None:
    table = np.arange(2.0 * len(COLUMNS)).reshape(2, -1)
    columns = trace.by_name(table)
    assert list(columns) == list(COLUMNS)
    assert columns["phase"].tolist() == [1.0, 1.0 + len(COLUMNS)]


def test_the_controller_powers_up_on_the_encoder_not_on_the_truth() -> None:
    rig = rigs.rig("bench", 1)
    calibration = rigs.uncalibrated(rig.profile)
    for kind in CompensationKind:
        loop, start = rigs.assemble(rig, PAPER, kind, calibration, run=2)
        known = start.controller.core.governor.last.head_mm
        park = loop.controller.plan.motion.park_head_mm
        assert known == pytest.approx(park, abs=0.0025 + 1e-9)
        play_mm = 0.5 * rig.machine.gear_backlash_mm
        assert start.machine.head_mm - known == pytest.approx(play_mm, abs=0.0025 + 1e-9)
        assert start.controller.core.procedure.phase == Phase.PARKED
