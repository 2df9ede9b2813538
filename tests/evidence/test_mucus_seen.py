"""Long campaign: how well the line tells whether mucus comes, on the whole twin.

Lines that are not as the controller's profile has them, in the closed loop; and sensors that are
noisy and off, on the vacuum of cycles that were recorded.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import Event
from opensuction.procedure.suction import line_flow
from opensuction.procedure.suction.line_flow import NOTHING_SEEN
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.cycle.resolution import APPROACHES
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.trace import Columns

SEEDS = range(31_000, 31_003)
FLOWING_ML_PER_S = 0.005
"""Mucus that comes: through 6 Fr it comes with .01 to .1 mL/s."""
NOTICED_S = 0.2
LINES: dict[str, dict[str, float]] = {
    "as the profile has it": {},
    "pump x .75": {"pump_free_ml_per_s": 0.75},
    "pump x 1.3": {"pump_free_ml_per_s": 1.3},
    "occluded vacuum x .7": {"pump_occluded_mmhg": 0.7},
    "regulator x 4": {"regulator_ml_per_s_per_mmhg": 4.0},
    "canister x .7": {"mmhg_per_ml": 1.0 / 0.7},
    "canister x .5": {"mmhg_per_ml": 2.0},
    "canister x 2": {"mmhg_per_ml": 0.5},
    "bore's flow x .85": {"bore_ml_per_s_per_root_mmhg": 0.85},
    "bore's flow x 1.15": {"bore_ml_per_s_per_root_mmhg": 1.15},
    "leak x 2.5": {"leak_ml_per_s_per_mmhg": 2.5},
}
"""Factors on the twin's line, its controller's profile unchanged."""
BLIND = "canister x .5"
"""Through 6 Fr mucus looks like gas then (decision 25)."""
SECRETIONS = [
    ("adult-icu", 1.0),
    ("adult-ards", 1.0),
    ("child-10kg", 1.0),
    ("neonate", 0.2),
    ("neonate", 0.04),
    ("child-10kg", 0.0),
]
"""Patients, and the share of their secretions that is there."""
SENSORS = [(0.0, 0.0), (2.0, 0.0), (2.0, 7.0), (2.0, -7.0)]
"""White noise and offset, mmHg."""
FILTERS_S = [0.0, 0.02]
FOLDER = Path("runs") / "soak"


def prepare(patient: str, approach: str, seed: int, secretions: float) -> Prepared:
    choice = CycleChoice(RigChoice(patient=patient, seed=seed), approach=approach)
    prepared = cycle_run.prepare(resolution.resolve(choice))
    bedside = prepared.start.bedside
    bedside = bedside._replace(secretion_ml=secretions * bedside.secretion_ml)
    return prepared._replace(start=prepared.start._replace(bedside=bedside))


def with_line(prepared: Prepared, factors: dict[str, float]) -> Prepared:
    machine = prepared.loop.machine
    changed = {name: factor * getattr(machine.line, name) for name, factor in factors.items()}
    line = machine.line._replace(**changed)
    return prepared._replace(loop=prepared.loop._replace(machine=machine._replace(line=line)))


def flows_ml_per_s(
    columns: Columns, seen_s: float
) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    """Mucus that came in the time before each tick."""
    removed, ticks = columns["truth.secretion_removed_ml"], round(seen_s / DT_S)
    return np.concatenate((np.zeros(ticks), removed[ticks:] - removed[:-ticks])) / seen_s


@pytest.mark.soak
@pytest.mark.parametrize(("patient", "secretions"), SECRETIONS)
def test_on_no_line_does_suction_end_while_mucus_comes(patient: str, secretions: float) -> None:
    found = {}
    for name, factors in LINES.items():
        ended, wrong, cycles = 0, 0, 0
        for seed in SEEDS:
            for approach in APPROACHES:
                prepared = with_line(prepare(patient, approach, seed, secretions), factors)
                columns = cycle_run.play(prepared)
                leaving = int(np.argmax(columns["phase"] == Phase.WITHDRAWING))
                cycles += 1
                if leaving and columns["cause"][leaving] == Event.NOTHING_CAME:
                    ended += 1
                    flow = flows_ml_per_s(columns, 0.1)[leaving - round(NOTICED_S / DT_S)]
                    wrong += flow > FLOWING_ML_PER_S
        found[name] = {"cycles": cycles, "ended": ended, "while it came": int(wrong)}
    FOLDER.mkdir(parents=True, exist_ok=True)
    file = FOLDER / f"mucus-seen-{patient}-{secretions:g}.json"
    file.write_text(json.dumps(found, indent=2) + "\n")
    thin = not patient.startswith("adult")
    for name, one in found.items():
        assert one["while it came"] == 0 or (thin and name == BLIND), name


@pytest.mark.soak
@pytest.mark.parametrize(("patient", "secretions"), SECRETIONS)
@pytest.mark.parametrize("filter_s", FILTERS_S)
@pytest.mark.parametrize(("noise_mmhg", "offset_mmhg"), SENSORS)
def test_with_no_sensor_is_mucus_taken_for_gas(
    patient: str, secretions: float, filter_s: float, noise_mmhg: float, offset_mmhg: float
) -> None:
    chance = np.random.default_rng(31)
    for seed in SEEDS:
        prepared = prepare(patient, "travel", seed, secretions)
        flow = prepared.loop.controller.plan.flow
        columns = cycle_run.play(prepared)
        sucking = np.flatnonzero(np.isin(columns["phase"], (Phase.OPENING, Phase.SUCTIONING)))
        coming = flows_ml_per_s(columns, 0.02)
        seen, filtered_mmhg, taken_s = NOTHING_SEEN, np.nan, 0.0
        for tick, noise in zip(sucking, chance.normal(0.0, noise_mmhg, sucking.size), strict=True):
            read_mmhg = columns["truth.line_vacuum_mmhg"][tick] + offset_mmhg + noise
            share = DT_S / (filter_s + DT_S)
            if np.isnan(filtered_mmhg):
                filtered_mmhg = read_mmhg
            filtered_mmhg += share * (read_mmhg - filtered_mmhg)
            pumping = bool(columns["commands.pump_on"][tick - 1])
            seen = line_flow.step(flow, seen, float(filtered_mmhg), True, pumping, DT_S)
            wrong = line_flow.is_nothing_coming(seen, DT_S) and coming[tick] > FLOWING_ML_PER_S
            taken_s = taken_s + DT_S if wrong else 0.0
            assert taken_s <= NOTICED_S, seed
