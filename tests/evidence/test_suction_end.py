"""Long campaign: what it does to patients that suction ends when nothing comes, and what it costs.

Every patient is suctioned twice by the same machine, with and without; the twin's truth judges.
"""

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.planning import planner
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns
from opensuction.twin.patient.patient_preset import AGE_GROUPS

SEEDS = range(30_000, 30_125)
"""For each of four patients and two approaches: 1,000 patients."""
FEW = range(30_000, 30_025)
FLOWING_ML_PER_S = 0.05
"""Mucus that comes."""
SEEN_S = 0.1
"""Time over which it is measured."""
NOTICED_S = 0.2
"""Mucus that begins to come so shortly before the way out cannot be seen by then."""
FOLDER = Path("runs") / "soak"


class Course(NamedTuple):
    """What a cycle came to."""

    removed_ml: float
    removed_percent: float
    lung_volume_loss_ml: float
    negative_pressure_s: float
    in_airway_s: float
    spo2_least_percent: float
    dwell_s: float
    """With the valve open, or opening, where the tip stopped."""
    rmse_mm: float
    ended_by_nothing: float
    """1 where the dwell ended for nothing came."""
    flow_at_end_ml_per_s: float
    """Mucus that came `NOTICED_S` before the way out, where that was why."""
    wrong: float
    """Trips, alarms and bounds for the patient that were broken."""


def set_pace(prepared: Prepared, **changes: float) -> Prepared:
    """The same cycle of the same patient, suction paced otherwise."""
    controller = prepared.loop.controller
    plan = controller.plan._replace(pace=controller.plan.pace._replace(**changes))
    return prepared._replace(loop=prepared.loop._replace(controller=controller._replace(plan=plan)))


def flow_ml_per_s(columns: Columns, tick: int) -> float:
    """Mucus that came before a tick."""
    removed, ticks = columns["truth.secretion_removed_ml"], round(SEEN_S / DT_S)
    return float(removed[tick] - removed[tick - ticks]) / SEEN_S


def play(prepared: Prepared) -> Course:
    columns = cycle_run.play(prepared)
    figures = cycle_run.figures(prepared, columns)
    assert figures.completed
    leaving = int(np.argmax(columns["phase"] == Phase.WITHDRAWING))
    noticed = leaving - round(NOTICED_S / DT_S)
    nothing = columns["cause"][leaving] == Event.NOTHING_CAME
    dwelling = np.isin(columns["phase"], (Phase.OPENING, Phase.SUCTIONING))
    return Course(
        removed_ml=figures.removed_ml,
        removed_percent=figures.removed_percent,
        lung_volume_loss_ml=figures.exposure.lung_volume_loss_ml,
        negative_pressure_s=figures.negative_pressure_s,
        in_airway_s=figures.exposure.in_airway_s,
        spo2_least_percent=figures.exposure.spo2_least_percent,
        dwell_s=float(np.count_nonzero(dwelling)) * DT_S,
        rmse_mm=figures.rmse_mm,
        ended_by_nothing=float(nothing),
        flow_at_end_ml_per_s=flow_ml_per_s(columns, noticed) if nothing else 0.0,
        wrong=float(len(figures.trips) + len(figures.alarms) + len(figures.harm)),
    )


def prepare(patient: str, approach: str, seed: int) -> Prepared:
    choice = CycleChoice(RigChoice(patient=patient, seed=seed), approach=approach)
    return cycle_run.oxygenate(cycle_run.prepare(resolution.resolve(choice)))


def describe(courses: list[Course]) -> dict[str, Any]:
    """Mean, deviation, least and most of each figure."""
    table = np.array(courses)
    return {
        name: {
            "mean": round(float(np.mean(column)), 4),
            "sd": round(float(np.std(column, ddof=1)), 4),
            "least": round(float(np.min(column)), 4),
            "most": round(float(np.max(column)), 4),
        }
        for name, column in zip(Course._fields, table.T, strict=True)
    }


def keep(name: str, result: dict[str, Any]) -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / f"{name}.json").write_text(json.dumps(result, indent=2) + "\n")


@pytest.mark.soak
@pytest.mark.parametrize("approach", APPROACHES)
@pytest.mark.parametrize("patient", AGE_GROUPS)
def test_no_patient_is_worse_off_for_it(patient: str, approach: str) -> None:
    pairs, refused = [], 0
    for seed in SEEDS:
        try:
            prepared = prepare(patient, approach, seed)
        except InputError:  # a short trachea by contact: no plan, with or without
            refused += 1
            continue
        pairs.append((play(set_pace(prepared, nothing_comes_s=0.0)), play(prepared)))
    without, ended = [list(column) for column in zip(*pairs, strict=True)]
    lost_ml = [before.removed_ml - after.removed_ml for before, after in pairs]
    longer_s = [after.negative_pressure_s - before.negative_pressure_s for before, after in pairs]
    more_ml = [after.lung_volume_loss_ml - before.lung_volume_loss_ml for before, after in pairs]
    keep(
        f"suction-ends-{patient}-{approach}",
        {
            "patients": len(pairs),
            "refused": refused,
            "without": describe(without),
            "with": describe(ended),
            "lost_ml": {"mean": float(np.mean(lost_ml)), "most": max(lost_ml)},
            "patients_who_keep_more": int(np.count_nonzero(np.array(lost_ml) > 0.01)),
            "lung_volume_more_ml": max(more_ml),
        },
    )
    assert refused <= 0.1 * len(SEEDS)
    assert max(longer_s) <= 0.05
    assert max(lost_ml) <= 0.1
    assert sum(course.wrong for course in ended) <= sum(course.wrong for course in without)
    assert max(course.flow_at_end_ml_per_s for course in ended) <= FLOWING_ML_PER_S


@pytest.mark.soak
@pytest.mark.parametrize("patient", ["adult-icu", "adult-ards"])
def test_the_time_and_the_speed_are_those_that_suit_adults(patient: str) -> None:
    """Longer waits and other speeds remove no more; each is played on the same patients."""
    paces = [
        (0.5, 5.0),
        (0.75, 5.0),
        (1.0, 5.0),
        (1.5, 5.0),
        (0.75, 3.0),
        (0.75, 8.0),
        (0.75, 30.0),
    ]
    played: dict[tuple[float, float], list[Course]] = {pace: [] for pace in paces}
    for seed in FEW:
        prepared = prepare(patient, "contact", seed)
        speed = prepared.protocol.withdrawal_mm_per_s
        for wait_s, slow in paces:
            changed = set_pace(prepared, nothing_comes_s=wait_s, slow_ratio=slow / speed)
            played[wait_s, slow].append(play(changed))
    keep(
        f"suction-ends-{patient}-paces",
        {f"{wait_s:g} s, {slow:g} mm/s": describe(one) for (wait_s, slow), one in played.items()},
    )
    removed = {pace: np.mean([one.removed_ml for one in found]) for pace, found in played.items()}
    chosen = removed[0.75, planner.SLOW_MM_PER_S]
    assert max(removed.values()) <= chosen + 0.02
    assert removed[0.75, 30.0] < chosen
