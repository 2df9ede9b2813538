"""The unit in the name of a recording's column: ``tip_mm``, ``Head (mm)``, ``x / mm``, ``t (ms)``.

Known units only, in their usual spellings. A word at the end of a name that is more often something
else (``motor_a``, ``head_min``, ``x_in``) counts where the name speaks of such a quantity; what
stands in brackets and is not known is asked for by the caller.
"""

import re
from typing import Final

from opensuction.kernel.errors import InputError
from opensuction.kernel.unit import unit_of

SECONDS: Final = {
    "ns": 1e-9,
    "us": 1e-6,
    "ms": 1e-3,
    "s": 1.0,
    "min": 60.0,
    "h": 3600.0,
    "d": 86400.0,
}
"""Units of time that a column may be in."""

_SPELLINGS: Final = {
    "": "- 1 UTC GMT hms h:m:s hh:mm:ss hh:mm:ss.f hh:mm:ss.fff hh:mm:ss.sss hh:mm:ss.000",
    "nm": "nanometre nanometres nanometer nanometers",
    "um": "µm micron microns micrometre micrometres micrometer micrometers",
    "mm": "millimetre millimetres millimeter millimeters",
    "cm": "centimetre centimetres centimeter centimeters",
    "m": "metre metres meter meters",
    "in": "inch inches",
    "ft": "feet",
    "deg": "° degs degree degrees",
    "rad": "radian radians",
    "mrad": "milliradian milliradians",
    "rev": "turn turns revolution revolutions",
    "rpm": "1/min",
    "counts": "count cnt cnts",
    "steps": "",
    "ticks": "",
    "pulses": "",
    "px": "pixel pixels",
    "N": "newton newtons",
    "uN": "µN",
    "mN": "",
    "kN": "",
    "lb": "lbs",
    "lbf": "",
    "kip": "kips",
    "gf": "",
    "kgf": "",
    "g": "gram grams",
    "kg": "kilogram kilograms",
    "Nm": "",
    "mNm": "",
    "J": "joule joules",
    "W": "watt watts",
    "kW": "",
    "A": "amp amps ampere amperes",
    "uA": "µA",
    "mA": "milliamp milliamps milliampere milliamperes",
    "V": "volt volts",
    "uV": "µV",
    "mV": "millivolt millivolts",
    "ohm": "ω ohms",
    "T": "tesla",
    "mT": "",
    "Pa": "pascal pascals",
    "hPa": "",
    "kPa": "",
    "MPa": "",
    "GPa": "",
    "bar": "",
    "mbar": "",
    "psi": "",
    "ksi": "",
    "mmHg": "",
    "cmH2O": "",
    "L": "l litre litres liter liters",
    "mL": "millilitre millilitres milliliter milliliters",
    "Hz": "hertz",
    "kHz": "",
    "MHz": "",
    "K": "kelvin",
    "degC": "°C celsius",
    "%": "percent pct",
    "ns": "nsec nanosecond nanoseconds",
    "us": "µs usec usecs microsecond microseconds",
    "ms": "msec msecs millis millisecond milliseconds",
    "s": "sec secs second seconds",
    "min": "mins minute minutes",
    "h": "hr hrs hour hours",
    "d": "day days",
}
"""How units are spelled, by their symbol; "" is that of a number alone, and of a time of day."""

_EXACT: Final = {
    spelling: symbol for symbol, more in _SPELLINGS.items() for spelling in (symbol, *more.split())
}
_SMALL: Final = {
    spelling.lower(): symbol for spelling, symbol in _EXACT.items() if len(spelling) > 1
} | {"nm": "nm"}
"""In any case; not those of one letter, for ``m`` and ``M`` are not the same."""

_TIME: Final = "time timestamp t elapsed clock dwell duration latency delay"
_QUANTITIES: Final = {
    "A": "current amp amps i",
    "N": "force load friction thrust tension preload f",
    "V": "volt volts voltage supply u",
    "W": "power",
    "L": "volume",
    "T": "flux field",
    "m": "position pos distance displacement disp length depth height travel stroke head tip",
    "in": "position pos distance displacement disp length depth height travel stroke",
    "Nm": "torque moment",
} | dict.fromkeys(SECONDS, _TIME)
"""What a name must speak of for these to be units at its end."""
_LETTERS: Final = {symbol.lower(): symbol for symbol in _QUANTITIES}

_NO_UNIT_AT_END: Final = frozenset(
    ("amp", "bar", "count", "ft", "ma", "mn", "nm", "rev", "turn", "turns", "un")
)
"""More often a word: amplitude, mean, number, filter, moving average, reverse, a turn, un-."""

_BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]")
_POWER = re.compile(r"(?:\^|\*\*)?([23])$")
_HUMP = re.compile(r"(?<=[^\W\dA-Z_])(?=[^\W\da-z_])")


def find_unit(text: str) -> str | None:
    """Symbol of a unit as people write it; "" of a number alone, None of what is no known unit.

    >>> [find_unit(text) for text in ("msec", "Millimetres", "deg/s", "m/s²", "1/mm", "furlong")]
    ['ms', 'mm', 'deg/s', 'm/s^2', '1/mm', None]
    """
    plain = text.strip().translate(str.maketrans("\u03bc\u2126\u00ba²³", "µω°23"))
    whole = _find_one(plain)
    if whole is not None:
        return whole
    written: list[str] = []
    for part in plain.split("/"):
        ones = [_find_power(one) for one in re.split(r"[\s·⋅]+|(?<!\*)\*(?!\*)", part.strip())]
        known = [one for one in ones if one]
        if None in ones or not (known or (not written and part.strip() == "1")):
            return None
        written.append(" ".join(known) or "1")
    return "/".join(written)


def _find_one(text: str) -> str | None:
    exact = _EXACT.get(text) if text else None
    return _SMALL.get(text.lower()) if exact is None else exact


def _find_power(text: str) -> str | None:
    """A unit that may be squared or cubed."""
    found, power = _find_one(text), _POWER.search(text)
    if found is not None or power is None:
        return found
    base = _find_one(text[: power.start()])
    return f"{base}^{power[1]}" if base else None


def unit_of_column(name: str) -> str | None:
    """Symbol of the unit in the name of a column.

    "" where there is none, None where brackets hold what may be one and is not known.

    >>> [unit_of_column(name) for name in ("tip_mm", "Head (mm)", "x / mm", "Tip_MM", "x", "y (5)")]
    ['mm', 'mm', 'mm', 'mm', '', '']
    >>> unit_of_column("motor_a"), unit_of_column("current_a"), unit_of_column("Head (furlong)")
    ('', 'A', None)
    """
    about = _BRACKETS.sub(" ", name)
    inside = [
        part.strip().removeprefix("in ")
        for group in _BRACKETS.findall(name)
        for part in re.split("[,;]", group)
    ]
    found = [_of_quantity(about, part) or find_unit(part) for part in inside]
    known = {unit for unit in found if unit}
    if len(known) == 1:
        return known.pop()
    unit = _unit_at_end(about.strip())
    unknown = any(
        one is None and any(letter.isalpha() for letter in part)
        for one, part in zip(found, inside, strict=True)
    )
    return None if known or (unknown and not unit) else unit


def _unit_at_end(name: str) -> str:
    """The unit behind the last underscore, space or stroke of a name; "" where there is none."""
    _, stated, last = name.rpartition(" in ")
    if stated and (unit := find_unit(last)):
        return unit
    about, stroke, last = name.rpartition("/")
    if stroke and len(last.strip()) > 1 and (unit := find_unit(last)):
        return unit
    if stroke:
        return _of_quantity(about, last.strip()) or ""
    parted = re.sub(r"[\s.,-]+", "_", name)
    for written in (parted, _HUMP.sub("_", parted)):
        several = unit_of(written.lower())
        if "/" in several or " " in several or "^" in several:
            return several
        about, _, last = written.rpartition("_")
        unit = _find_one(last) if len(last) > 1 and last not in _NO_UNIT_AT_END else None
        if unit in _QUANTITIES or not unit:
            unit = _of_quantity(about, last)
        if unit:
            return unit
    return ""


def _of_quantity(about: str, text: str) -> str | None:
    """A unit of `_QUANTITIES`, where the words before it are of such a quantity."""
    symbol = _LETTERS.get(text.lower()) or _find_one(text)
    words = re.split("[^a-z]+", _HUMP.sub("_", about).lower())
    return symbol if symbol and {*words} & {*_QUANTITIES.get(symbol, "").split()} else None


def seconds_of_column(name: str, given: str | None, option: str = "--time-unit") -> float:
    """Seconds in the unit of a column of time: the one that was given, else the one in its name.

    Without either it is in seconds. Raises InputError for what is no unit of time.
    """
    known = ", ".join(SECONDS)
    if given is not None:
        unit = find_unit(given)
        if unit not in SECONDS:
            raise InputError(f"{option} '{given}': should be one of {known}")
        return SECONDS[unit]
    unit = unit_of_column(f"time {name}")
    if unit == "":
        return 1.0
    if unit not in SECONDS:
        what = "no known unit" if unit is None else f"in {unit}, no unit of time"
        raise InputError(f"--time '{name}': is {what}; give {option} ({known})")
    return SECONDS[unit]


def seconds_in_name(name: str) -> float:
    """Seconds in the unit of time that a name ends in; 1 where it ends in none.

    Dates are read as the column's name says, so that `seconds_of_column` finds them in its unit.

    >>> seconds_in_name("stamp_ms"), seconds_in_name("stamp"), seconds_in_name("t (hh:mm:ss)")
    (0.001, 1.0, 1.0)
    """
    return SECONDS.get(unit_of_column(f"time {name}") or "s", 1.0)
