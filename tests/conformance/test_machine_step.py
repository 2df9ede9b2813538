from collections.abc import Callable

import pytest

from opensuction.kernel.codegen import row
from opensuction.kernel.interface import Commands
from opensuction.twin import parameter, preset
from opensuction.twin.machine import machine
from opensuction.twin.machine.machine import Machine, Truth
from opensuction.twin.patient import patient_preset
from opensuction.twin.plant import PlantState
from tests.conformance.plain import run_plain
from tests.settled import settled
from tests.twin.holding import hold

TICKS = 2000


def script(tick: int) -> Commands:
    """Two seconds that use every part: the head crosses the gap and turns, the valve opens."""
    forth = tick < 1500
    return Commands(
        head_mm=0.0,
        insertion_v=20.0 if forth else -20.0,
        insertion_on=tick % 100 != 99,
        cam_rad=0.0,
        valve_v=12.0 if 50 < tick < 1500 else 0.0,
        valve_on=tick < 1600,
        pump_on=tick < 1800,
        vacuum_mmhg=100.0,
    )


see, sense = settled(machine.truth), settled(machine.read)


def played(twin: Machine, state: PlantState) -> list[list[float]]:
    """Truth and readings of every tick of the script."""
    rows = []
    for tick in range(TICKS):
        state = hold(twin, state, script(tick), 1)
        truth = [float(value) for value in see(twin, state.machine)]
        read = sense(twin, state.machine)
        readings = [float(value) for value in (*read[:-1], *read.monitor)]
        rows.append(truth + readings)
    return rows


def results() -> list[list[float]]:
    """On a drawn machine, carina and secretions just ahead."""
    drawn = parameter.draw(parameter.BENCH, 11)
    values = {**drawn, "carina_mm": 85.0, "secretion_above_carina_mm": 5.0}
    twin = preset.machine(values)
    return played(twin, preset.park(twin, values, 85.0, seed=11, run=2))


def bedside_results() -> list[list[float]]:
    """In the patient, who loses gas; not settled, which would take plain Python seconds."""
    values = parameter.draw(parameter.CLINICAL, 11)
    twin = preset.machine(values, patient_preset.patient("adult-ards", 11))
    nobody = twin._replace(has_patient=False)
    return played(twin, preset.park(nobody, values, 25.0, seed=11, run=2))


def lively_results() -> list[list[float]]:
    """In a patient who coughs twice a second or so, breathes, is turned, and misread."""
    values = parameter.draw(parameter.CLINICAL, 11)
    person = patient_preset.lively(patient_preset.patient("adult-ards", 11))
    habits = person.behaviour
    restless = habits._replace(
        cough=habits.cough._replace(provoked_per_s=20.0, refractory_s=0.1),
        effort=habits.effort._replace(per_s=1.0),
        posture=habits.posture._replace(per_s=10.0),
        artefact=habits.artefact._replace(per_s=10.0),
    )
    twin = preset.machine(values, person._replace(behaviour=restless))
    nobody = twin._replace(has_patient=False)
    return played(twin, preset.park(nobody, values, 25.0, seed=11, run=2))


PLAYS = {play.__name__: play for play in (results, bedside_results, lively_results)}


def all_results() -> dict[str, list[list[float]]]:
    return {name: play() for name, play in PLAYS.items()}


@pytest.fixture(scope="module")
def plainly() -> dict[str, list[list[float]]]:
    """All of them as plain Python."""
    plain = run_plain("tests.conformance.test_machine_step", "all_results")
    assert isinstance(plain, dict)
    return plain


@pytest.mark.parametrize("play", PLAYS.values())
def test_compiled_equals_plain_python(
    play: Callable[[], list[list[float]]], plainly: dict[str, list[list[float]]]
) -> None:
    plain, compiled = plainly[play.__name__], play()
    assert len(plain) == len(compiled) == TICKS
    names = row.columns(Truth)
    last = dict(zip(names, compiled[-1], strict=False))
    # The script did reach everything it means to compare.
    assert last["secretion_removed_ml"] > 0.0
    assert max(tick[names.index("contact_n")] for tick in compiled) > 0.1
    assert (last["lung_volume_ml"] > 0.0) is (play is not results)
    coughed = max(tick[names.index("muscle_cmh2o")] for tick in compiled) > 20.0
    assert coughed is (play is lively_results)
    for one, other in zip(plain, compiled, strict=True):
        # Same library functions; fused operations may differ in the last bit and then add up.
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9)
