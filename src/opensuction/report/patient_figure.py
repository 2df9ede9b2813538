"""Key figures of the patient: each with what it was before, and whether it came back."""

from opensuction.report.contradicting_alarms import HEART_RATE, LUNG_VOLUME, PRESSURE, SATURATION
from opensuction.report.figure import Figure, FigureVerdict, without_limit
from opensuction.report.summary import Summary, is_recorded, number, value
from opensuction.report.wording import quantity


def course(summary: Summary, key: str, unit: str, decimals: int) -> str:
    """What a sign was before and is at the end, and when it was back, in words; may be empty."""
    before, at_end = (
        number(summary, "vitals", key, "before"),
        number(summary, "vitals", key, "at_end"),
    )
    if before is None or at_end is None:
        return ""
    said = (
        f"before {quantity(before, unit, decimals)}, at the end {quantity(at_end, unit, decimals)}"
    )
    back_s = number(summary, "vitals", key, "recovered_s")
    if is_recorded(summary):  # which ends soon after the cycle
        return said
    if value(summary, "vitals", key, "is_back") is not True:
        return f"{said}: not back yet"
    return said if back_s is None else f"{said}: back after {quantity(back_s, 's', 0)}"


OWN = "within its range but for the patient's own cough or breath"


def _judged(summary: Summary, key: str, end: str) -> float | None:
    """An extreme of a sign without what the patient's own muscles did, where that is known."""
    relaxed = number(summary, "vitals", key, f"relaxed_{end}")
    return number(summary, "vitals", key, end) if relaxed is None else relaxed


def _is_own(summary: Summary, key: str) -> bool:
    """Whether only the patient's own muscles brought a sign out of its usual range."""
    lowest, highest = (
        number(summary, "vitals", key, "lowest"),
        number(summary, "vitals", key, "highest"),
    )
    least, most = (number(summary, "vitals", key, f"usual_{end}") for end in ("least", "most"))
    low = lowest is not None and least is not None and lowest < least
    return low or (highest is not None and most is not None and highest > most)


def _outside(summary: Summary, key: str, unit: str, decimals: int) -> tuple[FigureVerdict, str]:
    """Verdict on a sign's extremes, and the bound that they crossed in words."""
    lowest, highest = (_judged(summary, key, end) for end in ("lowest", "highest"))
    kinds = (("limit", FigureVerdict.BAD), ("usual", FigureVerdict.NOTICE))
    for kind, verdict in kinds:
        least, most = (number(summary, "vitals", key, f"{kind}_{end}") for end in ("least", "most"))
        words = "the limit of" if kind == "limit" else "the usual"
        if lowest is not None and least is not None and lowest < least:
            return verdict, f"below {words} {quantity(least, unit, decimals)}"
        if highest is not None and most is not None and highest > most:
            peak = quantity(highest, unit, decimals)
            return verdict, f"{peak} is over {words} {quantity(most, unit, decimals)}"
    return FigureVerdict.GOOD, "within its range"


def _sign(
    summary: Summary, name: str, key: str, old: float | None, unit: str, decimals: int
) -> Figure:
    """A sign by its key of ``vitals``. old: its value where a summary has no ``vitals``."""
    lowest = number(summary, "vitals", key, "lowest")
    if lowest is None:
        return without_limit(name, old, unit, decimals)
    verdict, remark = _outside(summary, key, unit, decimals)
    return Figure(
        name,
        quantity(lowest, unit, decimals),
        course(summary, key, unit, decimals),
        verdict,
        remark,
    )


def saturation(summary: Summary) -> Figure:
    """Lowest oxygen saturation against its usual range and the monitor's limit."""
    old = number(summary, "spo2_nadir_percent")
    return _sign(summary, SATURATION, "spo2_percent", old, "%", 1)


def heart_rate(summary: Summary) -> Figure:
    """Lowest heart rate against the monitor's limit."""
    return _sign(summary, HEART_RATE, "heart_rate_per_min", None, "/min", 0)


def airway_pressure(summary: Summary) -> Figure:
    """Airway pressure, from the lowest to the highest, against its usual range."""
    key, unit = "airway_pressure_cmh2o", "cmH2O"
    figure = _sign(summary, PRESSURE, key, number(summary, "airway_pressure_least_cmh2o"), unit, 1)
    lowest, highest = (
        number(summary, "vitals", key, "lowest"),
        number(summary, "vitals", key, "highest"),
    )
    if lowest is None or highest is None:
        return figure
    if figure.verdict is FigureVerdict.GOOD and _is_own(summary, key):
        figure = figure._replace(remark=OWN)
    return figure._replace(value=f"{lowest:.1f} to {quantity(highest, unit)}")


def lung_volume(summary: Summary) -> Figure:
    """Resting volume that was lost at most, against what closed suction takes."""
    lost = number(summary, "lung_volume_loss_ml")
    key = "lung_volume_loss_ml"
    usual = number(summary, "vitals", key, "usual_most")
    if lost is None or usual is None:
        return without_limit(LUNG_VOLUME, lost, "mL", 0)
    lost = max(lost, 0.0)
    verdict, remark = FigureVerdict.GOOD, f"within the usual {quantity(usual, 'mL', 0)}"
    gained = -(number(summary, "vitals", key, "lowest") or 0.0)
    if lost > usual:
        verdict, remark = FigureVerdict.NOTICE, f"over the usual {quantity(usual, 'mL', 0)}"
    elif gained > usual:
        verdict, remark = FigureVerdict.NOTICE, f"up to {quantity(gained, 'mL', 0)} gained"
    left = number(summary, "vitals", key, "at_end")
    course_words = ""
    if left is not None:
        is_back = value(summary, "vitals", key, "is_back") is True
        still = f"{quantity(abs(left), 'mL', 0)} {'less' if left >= 0.0 else 'more'} than before"
        back_s = number(summary, "vitals", key, "recovered_s")
        course_words = f"at the end {still}: not back yet"
        if is_back:
            course_words = "" if back_s is None else f"back after {quantity(back_s, 's', 0)}"
    return Figure(LUNG_VOLUME, quantity(lost, "mL", 0), course_words, verdict, remark)
