"""A valve that opens by itself at the edge of a phase: how far the tip goes in under its vacuum.

Instants are searched where a detector may be blind: from .1 s before to .1 s after each phase of a
cycle begins. Besides the beds' own machines, suction lines at the ends of what a machine file may
say of one whose pre-use test passes.
"""

from collections.abc import Container, Iterable
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from opensuction.evidence.campaign import played_cycle, sound_machine
from opensuction.evidence.campaign.played_cycle import JUDGED
from opensuction.evidence.campaign.sound_machine import SoundMachine
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import RowBuffer
from opensuction.twin.fault.fault import Fault

WAY_MM = 0.5
"""That a tip may go in under more than this:"""
TIP_MMHG = 20.0
SEED = 4300
PATIENTS = ("adult-icu", "child-10kg", "neonate")
APPROACHES = ("travel", "contact")
SMALL = "relief_mmhg = 90.0"
FILES = {
    "slow, unknown to its controller": ("canister_ml = 4000.0\npump_free_l_per_min = 12.0", ""),
    "slow": (
        "canister_ml = 4000.0\npump_free_l_per_min = 12.0",
        "canister_ml = 4000.0\npump_l_per_min = 12.0",
    ),
    "strong": ("pump_free_l_per_min = 40.0", "pump_l_per_min = 40.0"),
    "weak regulator": ("regulator_ml_per_s_per_mmhg = 25.0", ""),
    "stiff regulator": ("regulator_ml_per_s_per_mmhg = 500.0", ""),
    "wide catheter": ("bore_l_per_min = 40.0", ""),
    "thin catheter": ("bore_l_per_min = 0.5", ""),
    "pump of 720 mmHg": ("pump_occluded_mmhg = 720.0", ""),
    "slow valve": ("cam_no_load_rad_per_s = 1.0", "cam_rad_per_s = 0.7"),
}
"""What the twin is, and what its controller knows of it."""
SWEPT_FILES = {("slow", "adult-icu", "contact"), ("slow valve", "neonate", "contact")}


def _cases(all_of_them: Iterable[tuple[str, ...]], swept: Container[tuple[str, ...]]) -> list[Any]:
    """Those that `.ci/run` tries, and the others for the long runs."""
    marks = {True: pytest.mark.sweep, False: pytest.mark.soak}
    return [pytest.param(*one, marks=marks[one in swept]) for one in all_of_them]


@cache
def room() -> RowBuffer:
    return played_cycle.make_room(JUDGED)


@cache
def sound(patient: str, approach: str, machine: str | None = None) -> SoundMachine:
    rig = RigChoice(patient=patient, seed=SEED)
    if machine is not None:
        rig = rig._replace(machine=machine)
    choice = CycleChoice(rig, approach=approach)
    return sound_machine.play(cycle_run.prepare(resolution.resolve(choice)), room())


def edges_s(machine: SoundMachine) -> dict[Phase, float]:
    """When each phase of the sound cycle begins."""
    phase = machine.rows[room().names.index("phase")]
    begins = np.flatnonzero(np.diff(phase)) + 1
    return {Phase(int(phase[tick])): tick * DT_S for tick in begins}


def way_mm(machine: SoundMachine, at_s: float) -> float:
    """Way in under vacuum with a valve that opens wholly at an instant."""
    fault = Injection(Fault.VALVE_STUCK_OPEN, FaultInstant(None, at_s), 1.0)
    truth = played_cycle.play_faulty(machine, (fault,), SEED, room()).run.columns
    inside = exposure.find_inside(machine.prepared.rig.machine, truth["truth.tip_mm"])
    sucking = inside & (truth["truth.tip_vacuum_mmhg"] > TIP_MMHG)
    return exposure.advance_mm(truth["truth.tip_mm"], sucking)


def search(machine: SoundMachine, step_ms: int) -> dict[tuple[str, int], float]:
    """Instants at which the tip went in too far, and how far."""
    found = {}
    for phase, begin_s in edges_s(machine).items():
        for off_ms in range(-100, 101, step_ms):
            at_s = begin_s + 0.001 * off_ms
            if at_s > 0.0 and (mm := way_mm(machine, at_s)) > WAY_MM:
                found[phase.name, off_ms] = mm
    return found


def write(path: Path, name: str, patient: str) -> str:
    """A machine file of a suction line, for a patient's age."""
    twin, known = FILES[name]
    adult = patient == "adult-icu"
    size, relief = ("12fr", "") if adult else ("6fr", SMALL)
    path.write_text(
        f'preset = "clinical"\ncatheter = "{size}"\nconduit = "standard"\n'
        f"[twin]\n{relief}\n{twin}\n[controller]\n{relief}\n{known}\n"
    )
    return str(path)


@pytest.mark.requirement("OS-R03")
@pytest.mark.parametrize("approach", APPROACHES)
@pytest.mark.parametrize("patient", PATIENTS)
def test_no_tip_goes_in_under_vacuum_whenever_the_valve_opens(patient: str, approach: str) -> None:
    assert search(sound(patient, approach), 50) == {}


@pytest.mark.requirement("OS-R03")
def test_the_way_in_is_searched_between_its_edges_too() -> None:
    machine = sound("adult-icu", "travel")
    begin = edges_s(machine)
    for at_s in np.arange(begin[Phase.INSERTING], begin[Phase.OPENING], 0.5):
        assert way_mm(machine, float(at_s)) <= WAY_MM, at_s


@pytest.mark.soak
@pytest.mark.parametrize("approach", APPROACHES)
@pytest.mark.parametrize("patient", PATIENTS)
def test_nor_at_any_instant_about_an_edge(patient: str, approach: str) -> None:
    assert search(sound(patient, approach), 5) == {}


@pytest.mark.requirement("OS-R03")
def test_nor_with_a_line_that_takes_long_to_be_pumped(tmp_path: Path) -> None:
    name = "slow, unknown to its controller"
    machine = sound("adult-icu", "travel", write(tmp_path / "m.toml", name, "adult-icu"))
    assert search(machine, 50) == {}


@pytest.mark.parametrize(
    ("name", "patient", "approach"),
    _cases(product(FILES, ("adult-icu", "neonate"), APPROACHES), SWEPT_FILES),
)
def test_nor_with_any_line_that_a_machine_file_may_have(
    name: str, patient: str, approach: str, tmp_path: Path
) -> None:
    machine = sound(patient, approach, write(tmp_path / "m.toml", name, patient))
    assert search(machine, 10) == {}
