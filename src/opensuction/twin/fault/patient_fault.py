"""What can go wrong with a patient: each a changed parameter, at any instant and strength.

Every function takes a patient and returns the patient with the fault; the state goes on. Nothing
of this is drawn by a seed.
"""

from opensuction.twin.patient.patient import L_PER_MIN, Patient


def disconnected(patient: Patient) -> Patient:
    """The circuit has come off the tube: the connector is open to the room."""
    return patient._replace(ventilator=patient.ventilator._replace(connected=False))


def mispressured(patient: Patient, ratio: float) -> Patient:
    """The ventilator gives a multiple of the pressures it was set to; above or below 1."""
    return patient._replace(ventilator=patient.ventilator._replace(pressure_ratio=ratio))


def flow_limited(patient: Patient, l_per_min: float) -> Patient:
    """The ventilator makes up for no more than this flow in expiration: suction takes more."""
    most = l_per_min / L_PER_MIN
    return patient._replace(ventilator=patient.ventilator._replace(compensation_ml_per_s=most))


def desaturating(patient: Patient, shunt: float) -> Patient:
    """This share of the blood passes no alveoli: the saturation falls within a minute."""
    return patient._replace(gas_exchange=patient.gas_exchange._replace(shunt=shunt))


def vagal(patient: Patient, ratio: float) -> Patient:
    """The strongest stimulus takes this share of the heart rate."""
    return patient._replace(heart=patient.heart._replace(vagal_ratio=ratio))


def unlinked(patient: Patient) -> Patient:
    """Nothing of the monitor arrives."""
    return patient._replace(monitor=patient.monitor._replace(linked=False))


def probe_off(patient: Patient) -> Patient:
    """The oximeter's probe has come off."""
    return patient._replace(monitor=patient.monitor._replace(probe_on=False))
