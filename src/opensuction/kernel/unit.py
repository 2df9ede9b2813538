"""The unit that the suffix of a field's name carries: ``speed_mm_per_s`` is in mm/s.

Units in terms of one another, and what of physics more than one room goes by.
"""

import re
from typing import Final

HOUR_S = 3600.0
ML_PER_S = 1000.0 / 60.0
"""mL/s for each L/min."""
PA_PER_MMHG = 133.322
ATMOSPHERE_MMHG = 760.0
BLASIUS_POWER = 19.0 / 7.0
"""Turbulent flow through a pipe at a given pressure loss grows with this power of its bore."""


_AS_WRITTEN: Final = ("cm", "deg", "h", "kg", "m", "min", "mm", "ms", "ohm", "rad", "s", "us")

SYMBOLS: Final = {
    **{unit: unit for unit in _AS_WRITTEN},
    "a": "A",
    "cmh2o": "cmH2O",
    "hz": "Hz",
    "kpa": "kPa",
    "l": "L",
    "ml": "mL",
    "mm2": "mm^2",
    "mm3": "mm^3",
    "mmhg": "mmHg",
    "n": "N",
    "n_s": "N s",
    "pa": "Pa",
    "percent": "%",
    "s2": "s^2",
    "v": "V",
    "v_s": "V s",
    "w": "W",
}
"""Suffix to symbol; ``_per_`` joins them. ``_ratio`` and names without a suffix have no unit."""

_ONE = "(?:" + "|".join(SYMBOLS) + ")"
_SUFFIX = re.compile(rf"(?:^|_)((?:{_ONE}|per_{_ONE})(?:_per_{_ONE})*)$")


def unit_of(name: str) -> str:
    """Symbol of the unit in the last part of a field's name, or "" where there is none.

    >>> [unit_of(name) for name in ("tip_mm", "decay_per_mm", "gain_v_s_per_mm", "open_ratio")]
    ['mm', '1/mm', 'V s/mm', '']
    """
    match = _SUFFIX.search(name)
    if match is None:
        return ""
    above, *below = re.split(r"_?per_", match[1])
    return "/".join([SYMBOLS.get(above, "1"), *(SYMBOLS[part] for part in below)])
