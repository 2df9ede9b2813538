"""One or more records of every catalogue model, with what theory promises of each.

A model that joins the catalogue joins here; `test_hysteresis_models` asks everything of it.
"""

from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import bouc_wen, generalised, modified_dahl
from opensuction.hysteresis.bank.maxwell_slip import MaxwellSlip
from opensuction.hysteresis.bank.play_readout import PlayReadout
from opensuction.hysteresis.bank.residual_readout import ResidualReadout
from opensuction.hysteresis.bouc_wen import BoucWen
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.hysteresis_model import HysteresisModel, Ranges, Record
from opensuction.hysteresis.dahl import Dahl
from opensuction.hysteresis.generalised import Generalised
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play import Play
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach

LOW_MM, HIGH_MM = 0.0, 100.0
"""Where the paths of the suite run."""

RANGES = Ranges(LOW_MM, HIGH_MM, -10.0, 85.0, output_mean_mm=40.0)


class Case(NamedTuple):
    """A record and what is promised of it."""

    name: str
    record: Record
    """Of the model ``name``."""
    forgetting_mm: float
    """Travel in one direction that leaves less than 1e-9 mm of the past."""
    closes_minor_loops: bool
    """Whether a minor loop returns exactly to where it left (return-point memory)."""
    loop_sign: int
    """Sense of its steady loops: -1 where the output lags the input, as backlash does, +1 where
    it leads, as a friction force does, 0 where parameters promise neither."""
    monotone: bool
    knows_time: bool = False
    """Whether a step is a sample, and what comes of it depends on how long a sample takes."""

    @property
    def refuses_inverse(self) -> bool:
        """Numerical inverses are refused where the root found would be one of several."""
        refusing = {"bouc-wen", "generalised", "residual-readout", "maxwell-slip"}
        return not self.monotone and self.name in refusing

    @property
    def model(self) -> HysteresisModel:
        """The catalogue's entry."""
        return CATALOGUE[self.name]


def _generalised(
    decays_mm: list[float], widths_mm: list[float], weights: list[float], envelope: list[float]
) -> Generalised:
    empty = generalised.on_range(
        LOW_MM, HIGH_MM, np.array(decays_mm), np.array(widths_mm), len(envelope) - 1
    )
    return generalised.with_factors(empty, np.array(weights + envelope))


def _preisach(levels: int, weight: float, ungapped: float) -> Preisach:
    """Weights that vary from cell to cell; the row without gap apart."""
    k, j = np.indices((levels, levels))
    weights_mm = weight * (1.0 + 0.3 * np.sin(3.0 * k + 2.0 * j)) * (k + j < levels)
    weights_mm[0] = ungapped * (1.0 + 0.5 * np.cos(np.arange(levels)))
    return Preisach(LOW_MM, HIGH_MM, weights_mm, -9.0)


def _readout(direct: float, lags: list[float]) -> PlayReadout:
    """Gains that vary from cell to cell; those of the play without width apart."""
    row, cell = np.indices((4, 7))
    gains = 0.2 * (1.0 + 0.6 * np.sin(2.0 * row + 1.3 * cell))
    gains[0] = direct * (1.0 + 0.4 * np.cos(np.arange(7)))
    return PlayReadout(
        low_mm=10.0,
        high_mm=90.0,
        widths_mm=np.array([0.0, 6.0, 14.0, 30.0]),
        gains=gains,
        decays_mm=np.array([9.0, 20.0][: len(lags)]),
        lags=np.array(lags),
        offset_mm=3.0,
    )


def _residual(velocity_gain: float) -> ResidualReadout:
    """Lines that vary from corner to corner; what fades is 0 in every past told as a ratio."""
    corner = np.arange(9)
    return ResidualReadout(
        low_mm=10.0,
        high_mm=90.0,
        slope=0.9,
        velocity_gain=velocity_gain,
        decay_per_mm=0.1,
        offset_mm=3.0,
        curve_mm=0.4 * np.sin(1.7 * corner),
        decays_mm=np.array([2.0, 14.0]),
        gains=np.array([0.05 * np.cos(1.1 * corner), 0.02 + 0.02 * np.sin(corner)]),
        fades_mm=np.array([5.0, 80.0]),
    )


def _slip(drags_mm: list[float]) -> MaxwellSlip:
    """Lines that fall where an element slips forward, by more than the slope makes good."""
    return MaxwellSlip(
        slope=0.5,
        reaches_mm=np.array([3.0, 12.0]),
        gains=np.array([[0.2, 0.1, 0.4, -0.3], [0.05, 0.3, 0.2, -0.35]]),
        speeds_mm_s=np.array([1.0, 5.0][: len(drags_mm)]),
        drags_mm=np.array(drags_mm),
        lag_s=4.0,
        period_s=1.0,
        offset_mm=-2.0,
    )


PASSIVE = BoucWen(1.0, 0.06, 0.02, 1.4, 0.95, -0.5, -7.0)

CASES: dict[str, Case] = {
    "dahl": Case("dahl", Dahl(0.05, 2.0), 1000.0, False, 1, True),
    "modified dahl, published": Case(
        # The difference of the lags decays with alpha from 22 mm at most: ln(22/1e-9) = 23.8.
        "modified-dahl",
        modified_dahl.PUBLISHED,
        24.0 / 0.077,
        False,
        -1,
        False,
    ),
    "modified dahl, monotone": Case(
        "modified-dahl", ModifiedDahl(0.95, 0.3, 0.1, -2.0), 240.0, False, -1, True
    ),
    # B = .091, D = 1.663: the way out of a saturated loop starts slowly, then forgets in 0.5 mm.
    "bouc-wen, published": Case("bouc-wen", bouc_wen.PUBLISHED, 100.0, False, 0, True),
    "bouc-wen, passive": Case("bouc-wen", PASSIVE, 600.0, False, -1, True),
    "bouc-wen, m = 1": Case(
        "bouc-wen", PASSIVE._replace(exponent=1.0, memory_gain=-0.8), 600.0, False, -1, False
    ),
    "play": Case("play", Play(20.0, 0.95, -6.2), 20.0, True, -1, False),
    "prandtl-ishlinskii": Case(
        "prandtl-ishlinskii",
        PrandtlIshlinskii(
            np.array([4.0, 9.0, 10.5, 13.0]), np.array([0.1, 0.3, 0.35, 0.1]), 0.1, -6.2, 0.0
        ),
        26.0,
        True,
        -1,
        True,
    ),
    "prandtl-ishlinskii, with a gap": Case(
        "prandtl-ishlinskii",
        PrandtlIshlinskii(np.array([7.0, 10.0]), np.array([0.4, 0.5]), 0.0, -6.2, 0.0),
        20.0,
        True,
        -1,
        False,
    ),
    "preisach": Case("preisach", _preisach(12, 0.9, 2.0), 101.0, True, -1, True),
    "preisach, with gaps": Case("preisach", _preisach(9, 1.5, 0.0), 101.0, True, -1, False),
    "play readout": Case("play-readout", _readout(0.5, []), 31.0, True, -1, True),
    "play readout, slow": Case("play-readout", _readout(0.5, [0.1, -0.05]), 600.0, False, -1, True),
    "play readout, with gaps": Case("play-readout", _readout(0.0, []), 31.0, True, -1, False),
    "generalised": Case(
        "generalised",
        _generalised(
            [2.0, 12.0], [9.0, 21.0], [0.05, 0.1, 0.2, 0.1], [40.0, 35.0, 3.0, 2.0, -1.0, 0.7]
        ),
        300.0,
        False,
        -1,
        True,
    ),
    "generalised, plays": Case(
        "generalised",
        _generalised([], [14.0, 20.0, 26.0], [0.3, 0.35, 0.3], [-6.0, 5.0, 1.0]),
        26.0,
        True,
        -1,
        True,
    ),
    "generalised, wrong way": Case(
        "generalised", _generalised([8.0], [], [0.6], [40.0, 48.0]), 200.0, False, -1, False
    ),
    "residual readout": Case("residual-readout", _residual(0.6), 400.0, False, -1, False),
    "maxwell slip": Case("maxwell-slip", _slip([]), 24.0, True, 0, False),
    "maxwell slip, with drag": Case(
        "maxwell-slip", _slip([0.5, 0.05]), 24.0, False, 0, False, knows_time=True
    ),
}
