"""Effects of a cycle on the patient, in words."""

from opensuction.report import patient_figure
from opensuction.report.figure import ATTENTION, Figure
from opensuction.report.summary import Summary, number
from opensuction.report.wording import capitalise, quantity, stopped


def heart_and_blood(summary: Summary) -> str:
    """Saturation and heart rate in words; empty where there is no patient."""
    return _join(_saturation(summary), _heart_rate(summary))


def lungs(summary: Summary) -> str:
    """Lung volume and airway pressure in words; empty where there is no patient."""
    return _join(_volume(summary), _pressure(summary))


def _join(*said: str) -> str:
    known = [part for part in said if part]
    return stopped(capitalise("; ".join(known))) if known else ""


def _but(figure: Figure) -> str:
    """What is wrong with a figure, in brackets; empty where nothing is."""
    return f" ({figure.remark})" if figure.verdict in ATTENTION else ""


def _saturation(summary: Summary) -> str:
    lowest = number(summary, "spo2_nadir_percent")
    if lowest is None:
        return ""
    said = f"oxygen saturation was {quantity(lowest, '%')} at its lowest"
    before = number(summary, "vitals", "spo2_percent", "before")
    at_end = number(summary, "vitals", "spo2_percent", "at_end")
    if before is None or at_end is None:
        return said
    wrong = _but(patient_figure.saturation(summary))
    return f"{said}{wrong}, {quantity(before, '%')} before and {quantity(at_end, '%')} at the end"


def _heart_rate(summary: Summary) -> str:
    lowest = number(summary, "vitals", "heart_rate_per_min", "lowest")
    if lowest is None:
        return ""
    wrong = _but(patient_figure.heart_rate(summary))
    return f"heart rate was {quantity(lowest, '/min', 0)} at its lowest{wrong}"


def _volume(summary: Summary) -> str:
    lost = number(summary, "lung_volume_loss_ml")
    if lost is None:
        return ""
    if round(lost) <= 0:
        return "the lungs lost none of their resting volume"
    wrong = _but(patient_figure.lung_volume(summary))
    return f"the lungs lost up to {quantity(lost, 'mL', 0)} of their resting volume{wrong}"


def _pressure(summary: Summary) -> str:
    least = number(summary, "airway_pressure_least_cmh2o")
    if least is None:
        return ""
    below = ", below the air outside" if least < 0.0 else ""
    said = f"the lowest airway pressure was {quantity(least, 'cmH2O')}{below}"
    wrong = patient_figure.airway_pressure(summary)
    lowest, highest = (
        number(summary, "vitals", "airway_pressure_cmh2o", name) for name in ("lowest", "highest")
    )
    if lowest is not None and round(lowest, 1) < round(least, 1):
        said += f", {quantity(lowest, 'cmH2O')} in a breath of the patient's own"
    if highest is not None:
        said += f", the highest {quantity(highest, 'cmH2O')}"
    remarkable = wrong.verdict in ATTENTION or wrong.remark == patient_figure.OWN
    return f"{said}: {wrong.remark}" if remarkable else said
