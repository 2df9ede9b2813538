"""Faults of the patient, and of ventilator and monitor at the bed; the bench has none of them."""

from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import Strength, in_patient, row
from opensuction.twin.patient.patient import L_PER_MIN_PER_ML_PER_S

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
}
