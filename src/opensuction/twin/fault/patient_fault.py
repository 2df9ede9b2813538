"""Faults of the patient, and of ventilator and monitor at the bed; the bench has none of them."""

from typing import Any

from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import FaultRow, PatientEffect, Strength
from opensuction.twin.patient.patient import L_PER_MIN_PER_ML_PER_S, Patient


def _with_ventilator(patient: Patient, **values: Any) -> Patient:
    return patient._replace(ventilator=patient.ventilator._replace(**values))


ROWS = (
    FaultRow(
        Fault.CIRCUIT_DISCONNECTED,
        "the breathing circuit has come off the tube",
        PatientEffect(lambda patient, _: _with_ventilator(patient, connected=False)),
        detected_by="pressure at the connector on the patient monitor",
    ),
    FaultRow(
        Fault.VENTILATOR_PRESSURE,
        "the ventilator gives a multiple of the pressures it is set to",
        PatientEffect(lambda patient, ratio: _with_ventilator(patient, pressure_ratio=ratio)),
        Strength("of the pressures it is set to", "1", 0.0, 4.0, 3.0),
        detected_by="pressure at the connector on the patient monitor",
    ),
    FaultRow(
        Fault.DESATURATION,
        "blood passes the lung without oxygen",
        PatientEffect(
            lambda patient, shunt: patient._replace(
                gas_exchange=patient.gas_exchange._replace(shunt=shunt)
            )
        ),
        Strength("share of the blood that does", "1", 0.3, 0.9, 0.7),
        detected_by="saturation on the patient monitor, late",
    ),
    FaultRow(
        Fault.BRADYCARDIA,
        "the heart slows when the airway is touched",
        PatientEffect(
            lambda patient, ratio: patient._replace(heart=patient.heart._replace(vagal_ratio=ratio))
        ),
        Strength("share of the rate that the strongest stimulus takes", "1", 0.5, 0.9, 0.8),
        detected_by="heart rate on the patient monitor",
    ),
    FaultRow(
        Fault.LUNG_VOLUME_LOST,
        "the ventilator makes up for less gas than suction takes",
        PatientEffect(
            lambda patient, l_per_min: _with_ventilator(
                patient, compensation_ml_per_s=l_per_min / L_PER_MIN_PER_ML_PER_S
            )
        ),
        Strength("flow that it makes up for", "L/min", 0.0, 30.0, 0.0),
        detected_by="pressure at the connector on the patient monitor",
    ),
    FaultRow(
        Fault.MONITOR_LOST,
        "nothing of the patient monitor arrives",
        PatientEffect(
            lambda patient, _: patient._replace(monitor=patient.monitor._replace(linked=False))
        ),
        detected_by="the link's own silence",
    ),
)
