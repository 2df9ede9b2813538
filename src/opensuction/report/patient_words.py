"""Effects of a cycle on the patient, in words."""

from opensuction.report import patient_figure
from opensuction.report.figure import ATTENTION, Figure
from opensuction.report.wording import capitalise, quantity, stopped
from opensuction.result.cycle_result import CycleResult


def heart_and_blood(result: CycleResult) -> str:
    """Saturation and heart rate in words; empty where there is no patient."""
    return _join(_saturation(result), _heart_rate(result))


def lungs(result: CycleResult) -> str:
    """Lung volume and airway pressure in words; empty where there is no patient."""
    return _join(_volume(result), _pressure(result))


def _join(*said: str) -> str:
    known = [part for part in said if part]
    return stopped(capitalise("; ".join(known))) if known else ""


def _but(figure: Figure) -> str:
    """Remark on a figure outside its limits, in brackets; empty for one within them."""
    return f" ({figure.remark})" if figure.verdict in ATTENTION else ""


def _saturation(result: CycleResult) -> str:
    lowest = result.spo2_nadir_percent
    if lowest is None:
        return ""
    said = f"oxygen saturation was {quantity(lowest, '%')} at its lowest"
    sign = result.signs.spo2_percent
    if sign is None or sign.before is None or sign.at_end is None:
        return said
    wrong = _but(patient_figure.saturation(result))
    before, at_end = quantity(sign.before, "%"), quantity(sign.at_end, "%")
    return f"{said}{wrong}, {before} before and {at_end} at the end"


def _heart_rate(result: CycleResult) -> str:
    sign = result.signs.heart_rate_per_min
    if sign is None:
        return ""
    wrong = _but(patient_figure.heart_rate(result))
    return f"heart rate was {quantity(sign.lowest, '/min', 0)} at its lowest{wrong}"


def _volume(result: CycleResult) -> str:
    lost = result.lung_volume_loss_ml
    if lost is None:
        return ""
    if round(lost) <= 0:
        return "the lungs lost none of their resting volume"
    wrong = _but(patient_figure.lung_volume(result))
    return f"the lungs lost up to {quantity(lost, 'mL', 0)} of their resting volume{wrong}"


def _pressure(result: CycleResult) -> str:
    least = result.airway_pressure_least_cmh2o
    if least is None:
        return ""
    below = ", below the air outside" if least < 0.0 else ""
    said = f"the lowest airway pressure was {quantity(least, 'cmH2O')}{below}"
    wrong = patient_figure.airway_pressure(result)
    sign = result.signs.airway_pressure_cmh2o
    if sign is not None and round(sign.lowest, 1) < round(least, 1):
        said += f", {quantity(sign.lowest, 'cmH2O')} in a breath of the patient's own"
    if sign is not None and sign.highest is not None:
        said += f", the highest {quantity(sign.highest, 'cmH2O')}"
    remarkable = wrong.verdict in ATTENTION or wrong.remark == patient_figure.OWN
    return f"{said}: {wrong.remark}" if remarkable else said
