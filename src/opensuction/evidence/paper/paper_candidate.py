"""Conduits that the paper's may have been: plays, and one thing more.

Each was brought to the paper's loop by `paper_plant.solve`; the numbers of ``CANDIDATES`` are what
that found.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import ndtri

from opensuction.hysteresis import play
from opensuction.kernel import random_stream

Values = npt.NDArray[np.float64]

RATE_HZ = 50.0
"""Samples of a recording: the models are independent of it."""
PLAYS = 40
"""Of a conduit."""
NOISE_SEED, NOISE_PURPOSE = 5, 1
"""Of the candidates that are noise."""


def _cosine_mm() -> Values:
    time_s = np.arange(0.0, 40.0, 1.0 / RATE_HZ)
    return 50.0 * (1.0 - np.cos(2.0 * math.pi * time_s / 20.0))


def _stroke_mm() -> Values:
    way = np.arange(0.0, 100.0, 10.0 / RATE_HZ)
    return np.concatenate([way, np.full(round(5.0 * RATE_HZ), 100.0), 100.0 - way])


EXCITATIONS: dict[str, Values] = {"cosine": _cosine_mm(), "stroke": _stroke_mm()}
"""Head positions: 0 to 100 mm and back twice as a cosine of 20 s, as assumed for the twin; once as
the paper's set-up is described (section IV-A): 10 mm/s, five seconds of standing, and back."""


class Conduit(NamedTuple):
    """A sum of plays, the head's way through it and what else it does."""

    width_mm: float
    """Mean width of the plays."""
    spread_mm: float
    """Its standard deviation: how round the corners of the loop are."""
    gain: float
    amount: float
    """Of what the candidate adds, in the unit that it names."""


Disturbed = Callable[[Conduit, Values], Values]
"""Tip positions of a conduit, without its offset, for head positions."""


class PlantCandidate(NamedTuple):
    """One thing that the paper's plant may have, with the numbers that bring it to the paper's."""

    name: str
    unit: str
    """Of the amount."""
    excitation: str
    tip_mm: Disturbed
    solved: Conduit
    """As `paper_plant.solve` finds it."""


def plays_mm(conduit: Conduit, head_mm: Values, share: float = 0.5) -> Values:
    """Tip of the plays alone. share: of its width by which each play begins above the head."""
    quantiles = ndtri((np.arange(PLAYS) + 0.5) / PLAYS)
    widths = conduit.width_mm + conduit.spread_mm * quantiles / float(np.std(quantiles))
    moved = [
        play.simulate(width, head_mm, float(head_mm[0]) + share * width)
        for width in np.maximum(widths, 0.0).tolist()
    ]
    return conduit.gain * np.asarray(np.mean(moved, axis=0))


def _late_mm(head_mm: Values, seconds: float) -> Values:
    """The head as it was some time ago."""
    time_s = np.arange(head_mm.size) / RATE_HZ
    return np.interp(time_s - abs(seconds), time_s, head_mm, left=float(head_mm[0]))


def _added(pattern: Callable[[Values], Values]) -> Disturbed:
    """Plays and a pattern of their output, in mm for an amount of 1."""

    def tip_mm(conduit: Conduit, head_mm: Values) -> Values:
        tip = plays_mm(conduit, head_mm)
        return tip + conduit.gain * conduit.amount * pattern(tip)

    return tip_mm


def _relaxed(drive: Values, seconds: float) -> Values:
    """Response of a first-order lag to a drive."""
    followed = np.zeros(drive.size)
    share = 1.0 / (RATE_HZ * seconds)
    for k in range(1, drive.size):
        followed[k] = followed[k - 1] + share * (drive[k] - followed[k - 1])
    return followed


def _white(tip: Values) -> Values:
    stream = random_stream.stream(NOISE_SEED, NOISE_PURPOSE)
    noise = np.empty(tip.size + tip.size % 2)
    for k in range(0, noise.size, 2):
        noise[k], noise[k + 1], stream = random_stream.normal_pair(stream)
    return noise[: tip.size]


def _slow(tip: Values) -> Values:
    noise = _relaxed(_white(tip), 1.0)
    return noise / float(np.std(noise))


def _creep(tip: Values) -> Values:
    speed = np.gradient(tip) * RATE_HZ
    return -_relaxed(speed / (np.abs(speed) + 3.0), 5.0)


def _other_way_back(conduit: Conduit, head_mm: Values) -> Values:
    """The plays are wider from the middle of the recording on."""
    half = head_mm.size // 2
    wider = conduit._replace(width_mm=conduit.width_mm + conduit.amount)
    return np.concatenate([plays_mm(conduit, head_mm)[:half], plays_mm(wider, head_mm)[half:]])


def _slipping(conduit: Conduit, head_mm: Values) -> Values:
    """The tip stands until it is behind by the amount, then it slips."""
    tip = plays_mm(conduit, head_mm)
    stood = float(tip[0])
    for k, wanted in enumerate(tip.tolist()):
        stood = wanted if abs(wanted - stood) > abs(conduit.amount) else stood
        tip[k] = stood
    return tip


def _late(conduit: Conduit, head_mm: Values) -> Values:
    return plays_mm(conduit, _late_mm(head_mm, conduit.amount))


def _sluggish(conduit: Conduit, head_mm: Values) -> Values:
    """The tip follows with a time constant."""
    start = float(head_mm[0])
    followed = start + _relaxed(head_mm - start, max(abs(conduit.amount), 1.0 / RATE_HZ))
    return plays_mm(conduit, followed)


def _rounder(conduit: Conduit, head_mm: Values) -> Values:
    """The amount is the spread itself."""
    return plays_mm(conduit._replace(spread_mm=abs(conduit.amount)), head_mm)


def _bow(tip: Values) -> Values:
    return ((tip - 50.0) / 50.0) ** 2


def _ripple(tip: Values) -> Values:
    return np.sin(2.0 * math.pi * tip / 60.0)


def _drift(tip: Values) -> Values:
    return np.linspace(-1.0, 1.0, tip.size)


ROUND_MM = 5.0
"""Spread of a loop round enough to leave room for something else: the twin's is 2."""


def _candidate(
    name: str, unit: str, tip_mm: Disturbed, solved: Conduit, excitation: str = "stroke"
) -> PlantCandidate:
    return PlantCandidate(name, unit, excitation, tip_mm, solved)


CANDIDATES: tuple[PlantCandidate, ...] = (
    _candidate(
        "plays alone",
        "mm",
        _rounder,
        Conduit(20.904, 0.0, 0.9438, 3.4525),
        "cosine",
    ),
    _candidate("plays alone", "mm", _rounder, Conduit(21.359, 0.0, 0.9438, 1.2258)),
    _candidate("white noise", "mm", _added(_white), Conduit(21.309, ROUND_MM, 0.9430, 0.5348)),
    _candidate(
        "white noise, corners rounder still",
        "mm",
        _added(_white),
        Conduit(20.220, 13.0, 0.9360, 0.8144),
    ),
    _candidate("noise of 1 s", "mm", _added(_slow), Conduit(21.324, ROUND_MM, 0.9411, 0.6265)),
    _candidate(
        "drift, either way", "mm", _added(_drift), Conduit(22.745, ROUND_MM, 0.9481, -1.5297)
    ),
    _candidate(
        "ripple along the way, 60 mm",
        "mm",
        _added(_ripple),
        Conduit(21.225, ROUND_MM, 0.9339, 1.0559),
    ),
    _candidate("creep of 5 s", "mm", _added(_creep), Conduit(22.714, ROUND_MM, 0.9352, -2.2132)),
    _candidate(
        "gap wider on the way back",
        "mm",
        _other_way_back,
        Conduit(20.126, ROUND_MM, 0.9502, 2.1675),
    ),
    _candidate("stick and slip", "mm", _slipping, Conduit(20.033, ROUND_MM, 0.9383, 1.4997)),
    _candidate(
        "gain that bows along the way",
        "mm",
        _added(_bow),
        Conduit(21.232, ROUND_MM, 0.9301, 4.6202),
    ),
    _candidate("tip late", "s", _late, Conduit(15.077, ROUND_MM, 0.9083, 0.3372)),
    _candidate("tip late, sharper corners", "s", _late, Conduit(16.360, 2.0, 0.9162, 0.2767)),
    _candidate("tip late", "s", _late, Conduit(20.134, 2.0, 0.9377, 0.0298), "cosine"),
    _candidate("tip sluggish", "s", _sluggish, Conduit(14.973, ROUND_MM, 0.9094, 0.3644)),
)
"""What was tried. Amounts: spread of the plays, RMS of a noise, half of a drift, height of a ripple
or bow, mm of creep, of gap or of a slip; delay or time constant."""

SHOWN = tuple(candidate for candidate in CANDIDATES if candidate.excitation == "stroke")
"""What a report has time for: a cosine takes six times as long."""
