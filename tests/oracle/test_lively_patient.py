"""The judge at a bed where the patient coughs: what the patient does is no harm of the machine's.

Tip, gas and mucus of a lively cycle are what the controller made of it; only the truth is judged.
"""

import numpy as np
import pytest

from opensuction.oracle import exposure, harm
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation.trace import Columns
from opensuction.twin.patient import patient_preset
from opensuction.twin.patient.patient import Patient

COUGHS_CMH2O = 30.0


def lively(one: Patient) -> Patient:
    """Who coughs all the time, with the catheter inside or not."""
    person = patient_preset.lively(one)
    often = person.behaviour.cough._replace(spontaneous_per_s=0.3, provoked_per_s=0.3)
    return person._replace(behaviour=person.behaviour._replace(cough=often))


def cycle(name: str, approach: str, seed: int) -> tuple[Prepared, Columns]:
    chosen = CycleChoice(RigChoice(patient=name, seed=seed), approach=approach)
    resolved = resolution.resolve(chosen)
    calm = cycle_run.prepare(resolved)
    machine = calm.rig.machine._replace(patient=lively(calm.rig.machine.patient))
    rig = calm.rig._replace(machine=machine)
    prepared = cycle_run.assemble(resolved, rig, calm.calibration)
    return prepared, cycle_run.play(prepared)


@pytest.mark.parametrize(
    ("name", "approach"),
    [("adult-icu", "travel"), ("adult-ards", "contact"), ("neonate", "contact")],
)
def test_a_cough_is_no_harm_and_its_pressure_not_the_machine_s(name: str, approach: str) -> None:
    prepared, columns = cycle(name, approach, 2)
    assert columns["truth.muscle_cmh2o"].max() > COUGHS_CMH2O
    assert columns["truth.carina_shift_mm"].min() < -0.5
    machine = prepared.rig.machine
    borne = exposure.measure(machine, columns)
    found = {one.name for one in harm.find(machine, borne, prepared.protocol.cap_mm)}
    allowed = {harm.SATURATION}  # of a lung that coughs itself empty, whosoever's doing it is
    assert found <= allowed
    # The same truth, judged as if the pressures were the machine's: it would be.
    taken = {
        **columns,
        "truth.relaxed_pressure_cmh2o": columns["truth.airway_pressure_cmh2o"],
        "truth.relaxed_loss_ml": columns["truth.lung_volume_loss_ml"],
    }
    blamed = exposure.measure(machine, taken)
    assert blamed.pressure_unsafe_s > borne.pressure_unsafe_s + 0.1
    assert blamed.lung_volume_loss_ml > borne.lung_volume_loss_ml


def test_suction_is_still_judged_while_the_patient_coughs() -> None:
    """A ventilator that makes up for nothing: the lung loses as much, coughing or not."""
    prepared, columns = cycle("adult-ards", "travel", 2)
    machine = prepared.rig.machine
    bled = np.where(columns["truth.tip_vacuum_mmhg"] > 1.0, -8.0, 12.0)
    taken = {**columns, "truth.relaxed_pressure_cmh2o": bled}
    assert exposure.measure(machine, taken).pressure_unsafe_s > 1.0
