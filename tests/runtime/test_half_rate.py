"""The loop at 500 Hz before a machine that moves at 1 kHz: the same cycle, the same figures."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from opensuction.kernel.interface import START
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure, harm
from opensuction.oracle.exposure import PatientExposure
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation.closed_loop import DT_S
from tests.runtime.stepped_room import SteppedRoom

AFTER_S = 1.0
SAME_MM = 0.05
"""How much deeper or less deep the tip may get: a servo told half as often rings otherwise, by
.02 mm in what was tried."""
SAME_S = 0.3
"""How much longer or shorter a phase may last. Where suction ends by what comes, it ends with a
window of .1 s, or the next one; the way out is slower while mucus comes."""


class Cycle(NamedTuple):
    """What came of one."""

    lasting_s: dict[str, float]
    """Of each phase, in order."""
    tripped: bool
    alone: bool
    """The drives had to act by themselves."""
    borne: PatientExposure
    harmed: tuple[str, ...]
    removed_ml: float
    tracking_mm: float
    """Root mean square of tip less reference, from the way in to the way out."""


def cycle(folder: Path, choice: CycleChoice, period: int) -> Cycle:
    """A cycle from power-up on. period: of the loop, in ticks of the machine."""
    prepared = cycle_run.prepare(resolution.resolve(choice))
    room = SteppedRoom(folder, prepared.loop, prepared.start, period)
    room.run(0.3)
    room.cycle()
    assert room.phase() == Phase.PARKED
    room.run(AFTER_S)
    room.close()
    columns, shown, machine = room.columns(), room.shown(), prepared.loop.machine
    phase = columns["outputs.phase"]
    borne = exposure.measure(machine, shown)
    found = harm.find(machine, borne, prepared.loop.controller.limits.cap_mm)
    tip_mm = shown["truth.tip_mm"][: len(phase) * period : period]
    off_mm = (tip_mm - columns["outputs.demand.reference_mm"])[
        (phase >= Phase.INSERTING) & (phase <= Phase.WITHDRAWING)
    ]
    return Cycle(
        {
            one.name: float(np.count_nonzero(phase == one)) * period * DT_S
            for one in Phase
            if one in phase
        },
        bool(columns["outputs.verdict.trips"].any()),
        bool(shown["alone"].any()),
        borne,
        tuple(one.name for one in found),
        float(shown["truth.secretion_removed_ml"][-1]),
        float(np.sqrt(np.mean(off_mm * off_mm))),
    )


@pytest.mark.parametrize(
    ("patient", "approach", "compensation"),
    [
        pytest.param("neonate", "travel", "exact-inverse", marks=pytest.mark.sweep),
        # Ended .6 to 1.1 s later by what comes.
        pytest.param("adult-icu", "contact", "preview", marks=pytest.mark.sweep),
        pytest.param("adult-ards", "travel", "preview", marks=pytest.mark.soak),
    ],
)
def test_a_cycle_at_500_hz_is_that_at_1_khz(
    tmp_path: Path, patient: str, approach: str, compensation: str
) -> None:
    choice = CycleChoice(
        RigChoice(patient=patient, seed=4 if patient == "adult-ards" else 3),
        approach=approach,
        compensation=compensation,
    )
    (tmp_path / "half").mkdir()
    full, half = cycle(tmp_path, choice, 1), cycle(tmp_path / "half", choice, 2)
    for one in (full, half):
        assert not one.tripped
        assert not one.alone
        assert one.harmed == ()
    assert list(half.lasting_s) == list(full.lasting_s)
    for name, lasts_s in full.lasting_s.items():
        assert half.lasting_s[name] == pytest.approx(lasts_s, abs=SAME_S), name
    assert half.borne.deepest_mm == pytest.approx(full.borne.deepest_mm, abs=SAME_MM)
    assert half.borne.force_peak_n == pytest.approx(full.borne.force_peak_n, abs=0.005)
    assert half.borne.vacuum_peak_mmhg == pytest.approx(full.borne.vacuum_peak_mmhg, abs=1.0)
    assert half.removed_ml == pytest.approx(full.removed_ml, rel=0.01)
    assert half.tracking_mm < full.tracking_mm + 0.05


def test_a_machine_that_says_nothing_is_told_as_soon_at_500_hz(tmp_path: Path) -> None:
    """20 ms are twenty ticks at 1 kHz and ten at 500 Hz."""
    silent_s = []
    for period in (1, 2):
        (tmp_path / str(period)).mkdir()
        prepared = cycle_run.prepare(resolution.resolve(CycleChoice(RigChoice(patient="neonate"))))
        room = SteppedRoom(tmp_path / str(period), prepared.loop, prepared.start, period)
        room.step(START)
        room.run(0.1)
        room.machine.stands_still = True
        known = len(room.rows)
        room.run(0.1)
        room.close()
        valid = room.columns()["inputs.readings.head_valid"][known:]
        silent_s.append(float(np.argmax(valid == 0.0)) * period * DT_S)
    assert silent_s[0] == pytest.approx(0.02, abs=0.002)
    assert silent_s[1] == pytest.approx(silent_s[0], abs=0.002)
