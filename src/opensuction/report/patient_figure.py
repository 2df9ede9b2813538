"""Key figures of the patient: each with what it was before, and whether it came back.

Effects of a cycle on the patient, in words.
"""

from opensuction.report.figure import ATTENTION, CycleFigure, Figure, FigureVerdict, without_limit
from opensuction.report.wording import capitalise, quantity, stopped
from opensuction.result.cycle_result import CycleResult, SignCourse


def course(result: CycleResult, sign: SignCourse | None, unit: str, decimals: int) -> str:
    """Values of a sign before and at the end, and its recovery, in words; may be empty."""
    if sign is None or sign.before is None or sign.at_end is None:
        return ""
    before, at_end = (quantity(one, unit, decimals) for one in (sign.before, sign.at_end))
    said = f"before {before}, at the end {at_end}"
    if result.is_recorded:  # which ends soon after the cycle
        return said
    if not sign.is_back:
        return f"{said}: not back yet"
    back_s = sign.recovered_s
    return said if back_s is None else f"{said}: back after {quantity(back_s, 's', 0)}"


OWN = "within its range but for the patient's own cough or breath"


def _judged(sign: SignCourse) -> tuple[float, float | None]:
    """Extremes of a sign without what the patient's own muscles did, where that is known."""
    lowest, highest = sign.relaxed_lowest, sign.relaxed_highest
    return (
        sign.lowest if lowest is None else lowest,
        sign.highest if highest is None else highest,
    )


def _is_own(sign: SignCourse) -> bool:
    """True if only the patient's own muscles brought a sign out of its usual range."""
    low = sign.usual_least is not None and sign.lowest < sign.usual_least
    highest, most = sign.highest, sign.usual_most
    return low or (highest is not None and most is not None and highest > most)


def _outside(sign: SignCourse, unit: str, decimals: int) -> tuple[FigureVerdict, str]:
    """Verdict on a sign's extremes, and the bound that they crossed in words."""
    lowest, highest = _judged(sign)
    kinds = (
        (sign.limit_least, sign.limit_most, FigureVerdict.BAD, "the limit of"),
        (sign.usual_least, sign.usual_most, FigureVerdict.NOTICE, "the usual"),
    )
    for least, most, verdict, words in kinds:
        if least is not None and lowest < least:
            return verdict, f"below {words} {quantity(least, unit, decimals)}"
        if highest is not None and most is not None and highest > most:
            peak = quantity(highest, unit, decimals)
            return verdict, f"{peak} is over {words} {quantity(most, unit, decimals)}"
    return FigureVerdict.GOOD, "within its range"


def saturation(result: CycleResult) -> Figure:
    """Lowest oxygen saturation against its usual range and the monitor's limit."""
    sign = result.signs.spo2_percent
    if sign is None:
        return without_limit(CycleFigure.SATURATION, result.spo2_nadir_percent, "%", 1)
    return Figure(
        CycleFigure.SATURATION,
        quantity(sign.lowest, "%", 1),
        course(result, sign, "%", 1),
        *_outside(sign, "%", 1),
    )


def heart_rate(result: CycleResult) -> Figure:
    """Lowest heart rate against the monitor's limit."""
    sign = result.signs.heart_rate_per_min
    if sign is None:
        return without_limit(CycleFigure.HEART_RATE, None, "/min", 0)
    return Figure(
        CycleFigure.HEART_RATE,
        quantity(sign.lowest, "/min", 0),
        course(result, sign, "/min", 0),
        *_outside(sign, "/min", 0),
    )


def airway_pressure(result: CycleResult) -> Figure:
    """Airway pressure, from the lowest to the highest, against its usual range."""
    sign, unit = result.signs.airway_pressure_cmh2o, "cmH2O"
    if sign is None:
        least = result.airway_pressure_least_cmh2o
        return without_limit(CycleFigure.PRESSURE, least, unit, 1)
    verdict, remark = _outside(sign, unit, 1)
    beside = course(result, sign, unit, 1)
    if sign.highest is None:
        value = quantity(sign.lowest, unit, 1)
        return Figure(CycleFigure.PRESSURE, value, beside, verdict, remark)
    if verdict is FigureVerdict.GOOD and _is_own(sign):
        remark = OWN
    value = f"{sign.lowest:.1f} to {quantity(sign.highest, unit)}"
    return Figure(CycleFigure.PRESSURE, value, beside, verdict, remark)


def lung_volume(result: CycleResult) -> Figure:
    """Resting volume that was lost at most, against what closed suction takes."""
    lost, sign = result.lung_volume_loss_ml, result.signs.lung_volume_loss_ml
    if lost is None or sign is None or sign.usual_most is None:
        return without_limit(CycleFigure.LUNG_VOLUME, lost, "mL", 0)
    lost, usual = max(lost, 0.0), sign.usual_most
    verdict, remark = FigureVerdict.GOOD, f"within the usual {quantity(usual, 'mL', 0)}"
    gained = -sign.lowest
    if lost > usual:
        verdict, remark = FigureVerdict.NOTICE, f"over the usual {quantity(usual, 'mL', 0)}"
    elif gained > usual:
        verdict, remark = FigureVerdict.NOTICE, f"up to {quantity(gained, 'mL', 0)} gained"
    value = quantity(lost, "mL", 0)
    return Figure(CycleFigure.LUNG_VOLUME, value, _volume_course(sign), verdict, remark)


def _volume_course(sign: SignCourse) -> str:
    """Recovery of the volume with its time, or the volume that is still lost at the end."""
    left, back_s = sign.at_end, sign.recovered_s
    if left is None:
        return ""
    if sign.is_back:
        return "" if back_s is None else f"back after {quantity(back_s, 's', 0)}"
    side = "less" if left >= 0.0 else "more"
    return f"at the end {quantity(abs(left), 'mL', 0)} {side} than before: not back yet"


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
    wrong = _but(saturation(result))
    before, at_end = quantity(sign.before, "%"), quantity(sign.at_end, "%")
    return f"{said}{wrong}, {before} before and {at_end} at the end"


def _heart_rate(result: CycleResult) -> str:
    sign = result.signs.heart_rate_per_min
    if sign is None:
        return ""
    wrong = _but(heart_rate(result))
    return f"heart rate was {quantity(sign.lowest, '/min', 0)} at its lowest{wrong}"


def _volume(result: CycleResult) -> str:
    lost = result.lung_volume_loss_ml
    if lost is None:
        return ""
    if round(lost) <= 0:
        return "the lungs lost none of their resting volume"
    wrong = _but(lung_volume(result))
    return f"the lungs lost up to {quantity(lost, 'mL', 0)} of their resting volume{wrong}"


def _pressure(result: CycleResult) -> str:
    least = result.airway_pressure_least_cmh2o
    if least is None:
        return ""
    below = ", below the air outside" if least < 0.0 else ""
    said = f"the lowest airway pressure was {quantity(least, 'cmH2O')}{below}"
    wrong = airway_pressure(result)
    sign = result.signs.airway_pressure_cmh2o
    if sign is not None and round(sign.lowest, 1) < round(least, 1):
        said += f", {quantity(sign.lowest, 'cmH2O')} in a breath of the patient's own"
    if sign is not None and sign.highest is not None:
        said += f", the highest {quantity(sign.highest, 'cmH2O')}"
    remarkable = wrong.verdict in ATTENTION or wrong.remark == OWN
    return f"{said}: {wrong.remark}" if remarkable else said
