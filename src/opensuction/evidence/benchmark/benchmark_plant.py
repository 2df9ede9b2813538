"""What the compensators of the benchmark are tried on: twins, and hysteresis models as plants.

Every plant is identified by the same excitation and the same estimators before it is compensated;
no compensator is handed a plant's parameters.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from opensuction.hysteresis import modified_dahl
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.duhem_family import BOUC_WEN_FORM
from opensuction.hysteresis.catalogue.hysteresis_model import Record, simulate
from opensuction.hysteresis.play import Play
from opensuction.identification.estimator import branch_curve, nonlinear, superposition
from opensuction.kernel import random_stream
from opensuction.kernel.phase import Phase
from opensuction.kernel.record import Array
from opensuction.procedure.cycle.plan import Excitation
from opensuction.simulation import rig as rigs

RETRACTED = -1.0
"""Memory after a long retract, the past of every run here."""
MATCHING = Excitation(range_mm=130.0, period_s=26.0, duration_s=52.0)
"""Recording that the model plants are matched to: as fast as the identification, and wider, since
the head goes beyond 100 mm when the tip goes to 90."""
MATCHING_RUN = 3
"""Number of the noise stream of that recording; identification and cycles have others."""
BOUC_WEN_EVERY = 40
"""Samples of the recording per sample that the Bouc-Wen plant is matched to: 1,300 are left, with
the residual of all 52,000 (.10 mm) in a tenth of the time."""
KEPT = 16
"""Recordings and identifications that are kept for the next plants, of an ordinary run's seeds."""
NOISE_STREAM = 40
"""Purpose of the laser noise that a model plant is identified under."""
NOISE_MM = 0.08
"""The bench's laser, its target and set-up together (`twin/preset.py`)."""

Plant = Callable[[Array], Array]
"""Tip positions of head positions that begin after a long retract, both of shape (n,)."""


class Twin(NamedTuple):
    """A plant that is the digital twin under the whole controller."""

    name: str
    machine: str
    protocol: str
    about: str
    conduit: str = "standard"
    scale: float = 1.0
    """Of every gap width, changed after the identification, behind the controller's back."""


class Model(NamedTuple):
    """A plant that is one hysteresis model on an ideal servo."""

    name: str
    about: str
    matched: Callable[[Array, Array], Plant]
    """The plant from head and tip of a bench."""


TWINS = (
    Twin("bench", "bench", "paper", "the paper's bench, each seed a drawn machine"),
    Twin(
        "clinical",
        "clinical",
        "adult",
        "the bedside machine on a drawn adult patient, taught by hand, protocol adult: the paper's "
        "cycle is for the bench only, so its figures are of another motion",
    ),
    Twin("bench-x0.7", "bench", "paper", "gap widths x 0.7 after the identification", scale=0.7),
    Twin("bench-x1.3", "bench", "paper", "gap widths x 1.3 after the identification", scale=1.3),
    Twin("short", "bench", "paper", "the short conduit, identified as it is", conduit="short"),
    Twin("looped", "bench", "paper", "the looped conduit, identified as it is", conduit="looped"),
)


def of_record(name: str, record: Record) -> Plant:
    """A record of the catalogue's model as a plant."""
    return lambda head: simulate(CATALOGUE[name], record, head, RETRACTED)


def _published(_head: Array, _tip: Array) -> Plant:
    return of_record("modified-dahl", modified_dahl.PUBLISHED)


def _bouc_wen(head: Array, tip: Array) -> Plant:
    found = nonlinear.fit_bouc_wen(head[::BOUC_WEN_EVERY], tip[::BOUC_WEN_EVERY])
    return of_record("bouc-wen", BOUC_WEN_FORM.record(found.vector))


def _play(head: Array, tip: Array) -> Plant:
    lines = branch_curve.fit_parallel(head, tip)
    gain = lines.spacing_mm / float(lines.inwards_mm[1] - lines.inwards_mm[0])
    width = float(lines.inwards_mm[0] - lines.outwards_mm[0])
    middle = 0.5 * float(lines.inwards_mm[0] + lines.outwards_mm[0])
    return of_record("play", Play(width, gain, lines.first_mm - gain * middle))


def _superposition(name: str, about: str) -> Model:
    model = CATALOGUE[name]
    return Model(name, about, lambda head, tip: superposition.fit(model, head, tip).simulate)


FITTED = "fitted to the bench drawn by the seed"
MODELS = (
    Model("modified-dahl", "eqs. (3) and (4), the published parameters", _published),
    Model("bouc-wen", FITTED, _bouc_wen),
    Model("play", f"{FITTED}: one gap with corners", _play),
    _superposition("prandtl-ishlinskii", f"{FITTED}, plays of known widths"),
    _superposition("preisach", FITTED),
    _superposition("generalised", FITTED),
)
LEFT_OUT = (
    "Dahl is left out as a plant: its output is a force that saturates, so no head brings its tip "
    "90 mm down. With the missing line added it is the modified Dahl model."
)
PLANTS: tuple[Twin | Model, ...] = (*TWINS, *MODELS)
NAMES = tuple(plant.name for plant in PLANTS)


@lru_cache(maxsize=KEPT)
def wide_recording(seed: int) -> tuple[Array, Array]:
    """Head and tip (mm) of the bench drawn by a seed, over all the travel that a cycle uses."""
    rig = rigs.rig("bench", seed)
    rig = rig._replace(profile=rig.profile._replace(excitation=MATCHING))
    columns = rigs.excite(rig, MATCHING_RUN)
    during = columns["phase"] == Phase.IDENTIFYING
    return columns["readings.head_mm"][during], columns["truth.laser_mm"][during]


@lru_cache(maxsize=KEPT)
def noise_mm(seed: int, samples: int) -> Array:
    """Noise of the laser over the identification of a model plant, shape (samples,)."""
    source = random_stream.stream(seed, NOISE_STREAM)
    values = np.empty(samples + samples % 2)
    for k in range(0, values.size, 2):
        values[k], values[k + 1], source = random_stream.normal_pair(source)
    return NOISE_MM * values[:samples]
