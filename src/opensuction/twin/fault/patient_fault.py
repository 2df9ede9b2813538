"""Faults of the patient, and of ventilator and monitor at the bed; the bench has none of them."""

import math

from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import MachineEffect, Strength, in_patient, row
from opensuction.twin.fault.fault_time import Course
from opensuction.twin.machine.machine import Machine
from opensuction.twin.patient.patient import L_PER_MIN_PER_ML_PER_S

COUGH_S = 0.4
"""[assumed] Time from the first to the last pressure of the muscles in one cough."""
COUGH_STEP_S = 0.01
"""The bedside's own step."""
SHORTENING_MM_PER_CMH2O = 0.15
"""[assumed] The trachea shortens by about a centimetre in a cough: 9 mm at 60 cmH2O."""


def _cough_share(_peak_cmh2o: float, since_s: float) -> float:
    """A pulse that rises and falls smoothly, at the middle of a step."""
    return math.sin(math.pi * (since_s + 0.5 * COUGH_STEP_S) / COUGH_S) ** 2


def _cough(machine: Machine, pressure_cmh2o: float) -> Machine:
    """Muscles that press on the lung are a lung that would rest at a smaller volume."""
    lung, airway = machine.patient.lung, machine.airway
    pressed = lung._replace(
        relaxed_ml=lung.relaxed_ml - lung.compliance_ml_per_cmh2o * pressure_cmh2o
    )
    nearer_mm = SHORTENING_MM_PER_CMH2O * pressure_cmh2o
    return machine._replace(
        patient=machine.patient._replace(lung=pressed),
        airway=airway._replace(carina_mm=airway.carina_mm - nearer_mm),
    )


def _decannulate(machine: Machine, out_mm: float) -> Machine:
    """The catheter comes with the tube, so that its tip is so much higher in the airway."""
    conduit, bed = machine.transmission, machine.patient
    return machine._replace(
        transmission=conduit._replace(offset_mm=conduit.offset_mm - out_mm),
        patient=bed._replace(ventilator=bed.ventilator._replace(connected=False)),
    )


ROWS = {
    Fault.CIRCUIT_DISCONNECTED: row(
        "the breathing circuit has come off the tube",
        in_patient("ventilator", lambda ventilator, _: ventilator._replace(connected=False)),
        detected_by="pressure at the connector on the patient monitor",
    ),
    Fault.VENTILATOR_PRESSURE: row(
        "the ventilator gives a multiple of the pressures it is set to",
        in_patient(
            "ventilator", lambda ventilator, ratio: ventilator._replace(pressure_ratio=ratio)
        ),
        Strength("of the pressures it is set to", "1", 0.0, 4.0, 3.0),
        detected_by="pressure at the connector on the patient monitor",
    ),
    Fault.DESATURATION: row(
        "blood passes the lung without oxygen",
        in_patient("gas_exchange", lambda gas, shunt: gas._replace(shunt=shunt)),
        Strength("share of the blood that does", "1", 0.3, 0.9, 0.7),
        detected_by="saturation on the patient monitor, late",
    ),
    Fault.BRADYCARDIA: row(
        "the heart slows when the airway is touched",
        in_patient("heart", lambda heart, ratio: heart._replace(vagal_ratio=ratio)),
        Strength("share of the rate that the strongest stimulus takes", "1", 0.5, 0.9, 0.8),
        detected_by="heart rate on the patient monitor",
    ),
    Fault.LUNG_VOLUME_LOST: row(
        "the ventilator makes up for less gas than suction takes",
        in_patient(
            "ventilator",
            lambda ventilator, l_per_min: ventilator._replace(
                compensation_ml_per_s=l_per_min / L_PER_MIN_PER_ML_PER_S
            ),
        ),
        Strength("flow that it makes up for", "L/min", 0.0, 30.0, 0.0),
        detected_by="pressure at the connector on the patient monitor",
    ),
    Fault.MONITOR_LOST: row(
        "nothing of the patient monitor arrives",
        in_patient("monitor", lambda monitor, _: monitor._replace(linked=False)),
        detected_by="the link's own silence",
    ),
    Fault.COUGH: row(
        "the patient coughs: pressure in the lung, and the trachea shortens for a moment",
        MachineEffect(_cough),
        Strength("peak pressure of the muscles", "cmH2O", 5.0, 150.0, 60.0),
        detected_by="pressure at the connector on the patient monitor",
        course=Course(lambda _: COUGH_STEP_S, _cough_share, COUGH_S),
    ),
    Fault.DECANNULATION: row(
        "the tube comes out of the stoma with the circuit, which now blows into the room",
        MachineEffect(_decannulate),
        Strength("how far it comes out", "mm", 10.0, 200.0, 120.0),
        detected_by="pressure at the connector on the patient monitor",
    ),
}
