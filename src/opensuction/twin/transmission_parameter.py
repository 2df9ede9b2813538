"""Parameters of transmissions of other classes: what they add to a machine's table, or change.

Rows as in `opensuction.twin.parameter`; gap or lag also goes with the conduit's bend and clearance,
as drawn, over the paper's. A class that is not on clearances alone has its own gain and offset.
"""

from opensuction.twin.conduit.play_line import TransmissionClass, TransmissionKind
from opensuction.twin.parameter import BENCH
from opensuction.twin.parameter_row import Parameter
from opensuction.twin.parameter_row import parameter_row as _p

_PRINTED = "[paper] III-B"

BOUC_WEN: dict[str, Parameter] = {
    "gain": BENCH["gain"]._replace(value=0.925, source=_PRINTED),
    "gain_per_100mm": BENCH["gain_per_100mm"]._replace(value=0.0, source=_PRINTED),
    "offset_mm": BENCH["offset_mm"]._replace(value=-7.097, source=_PRINTED),
    "bouc_wen_gain": _p(1.925, "1", (0.1, 10), "A of the Bouc-Wen memory", _PRINTED, 0.02),
    "bouc_wen_dissipation": _p(0.091, "mm^-m", (0.001, 10), "its B", _PRINTED),
    "bouc_wen_bend": _p(1.663, "mm^-m", (0, 10), "its D", _PRINTED),
    "bouc_wen_exponent": _p(1.009, "1", (1, 3), "its m", _PRINTED),
    "bouc_wen_memory_gain": _p(
        -0.4533, "mm/mm", (-10, 0), "tip travel for each mm of that memory", _PRINTED, 0.005
    ),
}
"""What the paper prints, taken in mm."""

RUBBING: dict[str, Parameter] = {
    "clearance_mm": BENCH["clearance_mm"]._replace(
        value=0.6, source="[assumed] a catheter that fills its conduit, and so rubs"
    ),
    "width_spread_mm": BENCH["width_spread_mm"]._replace(value=0.6, source="[assumed] as before"),
    "rub_static_mm": _p(
        1.6,
        "mm",
        (0.05, 10),
        "stretch by friction in slowest motion, one way",
        "[assumed] 1.4 N of drag on 0.9 N/mm",
        0.1,
    ),
    "rub_kinetic_mm": _p(
        1.0, "mm", (0.05, 10), "that once the catheter slides", "[assumed] 0.9 N", 0.05
    ),
    "rub_stribeck_mm_per_s": _p(
        4.0, "mm/s", (0.1, 50), "speed at which it begins to slide", "[assumed]", 0.3
    ),
    "rub_film_s": _p(
        0.05,
        "mm/(mm/s)",
        (0, 0.5),
        "stretch for each mm/s by a viscous film",
        "[assumed] 0.4 N more at 9 mm/s",
        0.005,
    ),
}
"""Little clearance, and friction that depends on speed in the place of ``stretch_mm``."""


def rows(chosen: TransmissionClass) -> dict[str, Parameter]:
    """Parameters that a class adds to a machine's table, or changes there."""
    if chosen.kind == TransmissionKind.BOUC_WEN:
        return BOUC_WEN
    if chosen.kind == TransmissionKind.RUBBING:
        return RUBBING
    if chosen.kind == TransmissionKind.RECORDED:
        source = f"[MRD-2018] conduit {chosen.name}"
        return {
            "gain": BENCH["gain"]._replace(value=1.0, source=source),
            "gain_per_100mm": BENCH["gain_per_100mm"]._replace(value=0.0, source=source),
            "offset_mm": BENCH["offset_mm"]._replace(value=chosen.offset_mm, source=source),
        }
    return {}
