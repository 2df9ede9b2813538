"""Plants of the benchmark: twins, and hysteresis models on an ideal servo.

Every plant is identified by the same excitation and the same estimators before it is compensated;
no compensator is handed a plant's parameters. Models fitted to our own bench are in the class of
our own twin; those that others published, that were fitted to real recordings, or whose lag depends
on speed are not.

Changes of a plant after its identification, unknown to the controller: the benchmark's columns.

A transmission's gap, gain and offset drift with the conduit's route, with temperature and with how
the catheter is clamped; polymers creep; commands come late. The compensator is told of none.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from opensuction.controller import machine_profile
from opensuction.hysteresis import bouc_wen, modified_dahl
from opensuction.hysteresis.bouc_wen import BoucWen
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.duhem_family import BOUC_WEN_FORM
from opensuction.hysteresis.catalogue.hysteresis_model import Record, simulate
from opensuction.hysteresis.generalised import Generalised
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.hysteresis.play import Play
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.hysteresis.preisach import Preisach
from opensuction.identification.estimator import branch_curve, nonlinear, superposition
from opensuction.kernel import random_stream
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.plan import Excitation
from opensuction.settings import conduit_file
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from opensuction.twin import parameter, preset, transmission_parameter
from opensuction.twin.conduit import play_line
from opensuction.twin.conduit.play_line import RecordedConduit
from opensuction.twin.machine import transmission
from opensuction.twin.machine.transmission import Creep, Transmission


class Disturbance(NamedTuple):
    """A change after the identification; as it stands here, none."""

    name: str = "as identified"
    gap_ratio: float = 1.0
    """Of every gap width, or of the lag in its place."""
    gain_ratio: float = 1.0
    """Of the tip's travel, reckoned from the head's position 0."""
    offset_mm: float = 0.0
    """That the tip is farther in."""
    creep_ratio: float = 1.0
    """Of the twin's creep. A model plant has none, so that it gets this multiple of the bench's."""
    delay_s: float = 0.0
    """By which commands come late: the head's on an ideal servo, the drives' at a twin."""
    cycles: int = 0
    """So many cycles that taught the compensation by a light barrier went before, without contact;
    a model plant alone has the barrier."""


NOTHING = Disturbance()
DISTURBANCES = (
    Disturbance("gap +10 %", gap_ratio=1.1),
    Disturbance("gap -10 %", gap_ratio=0.9),
    Disturbance("gain +2 %", gain_ratio=1.02),
    Disturbance("gain -2 %", gain_ratio=0.98),
    Disturbance("offset +2 mm", offset_mm=2.0),
    Disturbance("offset -2 mm", offset_mm=-2.0),
    Disturbance("creep x4", creep_ratio=4.0),
    Disturbance("5 ms delay", delay_s=0.005),
    Disturbance("gap +10 %, two cycles on", gap_ratio=1.1, cycles=2),
    Disturbance("gap -10 %, two cycles on", gap_ratio=0.9, cycles=2),
    Disturbance("offset +2 mm, two cycles on", offset_mm=2.0, cycles=2),
    Disturbance("offset -2 mm, two cycles on", offset_mm=-2.0, cycles=2),
)
DISTURBANCE_NAMES = tuple(one.name for one in DISTURBANCES)
MODEL_CREEP = preset.transmission_of(parameter.nominal(parameter.BENCH)).creep
"""Of the nominal bench."""


def _multiply(amplitudes: Creep, ratio: float) -> Creep:
    return amplitudes._replace(
        fast_mm=ratio * amplitudes.fast_mm, slow_mm=ratio * amplitudes.slow_mm
    )


def disturb_transmission(conduit: Transmission, disturbance: Disturbance) -> Transmission:
    """A twin's transmission with all but the delay."""
    widths = tuple(disturbance.gap_ratio * width for width in conduit.widths_mm)
    return conduit._replace(
        widths_mm=widths,
        lag_ratio=disturbance.gap_ratio * conduit.lag_ratio,
        gain=disturbance.gain_ratio * conduit.gain,
        offset_mm=conduit.offset_mm + disturbance.offset_mm,
        creep=_multiply(conduit.creep, disturbance.creep_ratio),
    )


def delay(head_mm: Array, disturbance: Disturbance, dt_s: float) -> Array:
    """Head positions as late as the disturbance has them; shape (n,), from rest."""
    ticks = round(disturbance.delay_s / dt_s)
    if ticks == 0:
        return head_mm
    return np.concatenate((np.full(ticks, head_mm[0]), head_mm[:-ticks]))


def disturb_tip(tip_mm: Array, at_head_0_mm: float, disturbance: Disturbance, dt_s: float) -> Array:
    """Tip positions of a model plant with gain, offset and creep changed; shape (n,).

    at_head_0_mm: its tip with the head at 0.
    """
    if disturbance.gain_ratio != 1.0:
        tip_mm = at_head_0_mm + disturbance.gain_ratio * (tip_mm - at_head_0_mm)
    if disturbance.offset_mm != 0.0:
        tip_mm = tip_mm + disturbance.offset_mm
    if disturbance.creep_ratio != 1.0:
        stronger = _multiply(MODEL_CREEP, disturbance.creep_ratio)
        tip_mm = tip_mm - transmission.lag_mm(stronger, tip_mm, dt_s)
    return tip_mm


RETRACTED = -1.0
"""Memory after a long retract, the past of every run here."""
MATCHING = Excitation(range_mm=130.0, period_s=26.0, duration_s=52.0)
"""Recording that the model plants are matched to: as fast as the identification, and wider, since
the head goes beyond 100 mm when the tip goes to 90."""
BENCH_STROKE = machine_profile.BENCH.excitation
"""Recording that a plant is identified by; the paper's."""
WHOLE_STROKE = Excitation(range_mm=120.0, period_s=24.0, duration_s=48.0)
"""The same over all of the stroke that a recorded conduit is scaled to: a real one is not alike all
along its way, and no recording tells of a part that was not passed."""
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
Laid = Callable[[float], Plant]
"""The plant whose gap is so many times as wide as it was at the identification."""


class Twin(NamedTuple):
    """A plant that is the digital twin under the whole controller."""

    name: str
    machine: str
    protocol: str
    about: str
    conduit: str | None = None
    """None: the standard one."""
    scale: float = 1.0
    """Of every gap width, changed after the identification, behind the controller's back."""
    in_class: bool = True
    """Whether its transmission is plays, as ours are."""


class Model(NamedTuple):
    """A plant that is one hysteresis model on an ideal servo."""

    name: str
    about: str
    matched: Callable[[Array, Array], Laid]
    """The plant from head and tip of a bench."""
    in_class: bool = True
    """Whether it was fitted to our own bench."""
    floor_mm: float | None = None
    """How far repeats lie apart in the recording that it was fitted to."""
    stroke: Excitation = BENCH_STROKE
    """By which it is identified."""


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


def _widen(record: Record, ratio: float) -> Record:
    """A model whose gap, or the lag in its place, is so many times as wide."""
    if isinstance(record, ModifiedDahl):
        return record._replace(decay_per_mm=record.decay_per_mm / ratio)
    if isinstance(record, BoucWen):
        bend = math.pow(ratio, -record.exponent)
        return record._replace(dissipation=bend * record.dissipation, bend=bend * record.bend)
    if isinstance(record, Play):
        return record._replace(width_mm=ratio * record.width_mm)
    if isinstance(record, PrandtlIshlinskii):
        return record._replace(thresholds_mm=ratio * record.thresholds_mm)
    if isinstance(record, Generalised):
        return record._replace(
            decay_lengths_mm=ratio * record.decay_lengths_mm, widths_mm=ratio * record.widths_mm
        )
    raise TypeError(f"nobody has said how {type(record).__name__} is made wider")


def _laid(name: str, record: Record) -> Laid:
    """A record of the catalogue's model, and that model with another gap."""
    return lambda ratio: of_record(name, record if ratio == 1.0 else _widen(record, ratio))


def _published(_head: Array, _tip: Array) -> Laid:
    return _laid("modified-dahl", modified_dahl.PUBLISHED)


def _bouc_wen(head: Array, tip: Array) -> Laid:
    found = nonlinear.fit_bouc_wen(head[::BOUC_WEN_EVERY], tip[::BOUC_WEN_EVERY])
    return _laid("bouc-wen", BOUC_WEN_FORM.record(found.vector))


def _play(head: Array, tip: Array) -> Laid:
    lines = branch_curve.fit_parallel(head, tip)
    gain = lines.spacing_mm / float(lines.inwards_mm[1] - lines.inwards_mm[0])
    width = float(lines.inwards_mm[0] - lines.outwards_mm[0])
    middle = 0.5 * float(lines.inwards_mm[0] + lines.outwards_mm[0])
    return _laid("play", Play(width, gain, lines.first_mm - gain * middle))


def _superposition(name: str, about: str) -> Model:
    """A model fitted to the bench; its past is the one that predicts the bench best."""

    def matched(head: Array, tip: Array) -> Laid:
        found = superposition.fit(CATALOGUE[name], head, tip)

        def laid(ratio: float) -> Plant:
            if ratio == 1.0:
                return found.simulate
            if isinstance(found.record, Preisach):
                wide = _rows_of(found.record)
                return lambda heads: play_line.tip_mm(wide, heads, ratio, found.memory_ratio)
            return found._replace(record=_widen(found.record, ratio)).simulate

        return laid

    return Model(name, about, matched)


def _rows_of(record: Preisach) -> RecordedConduit:
    """A Preisach model as plays side by side, whose widths may be others than whole levels."""
    levels = record.weights_mm.shape[0]
    grid = play_line.triangle(levels, levels, record.low_mm, record.high_mm)
    return grid._replace(gains=record.weights_mm / grid.cell_mm, offset_mm=record.offset_mm)


def _recorded(name: str) -> Model:
    """A conduit fitted to a real recording."""
    shipped = conduit_file.load(name)
    kind = "a Preisach model" if name in conduit_file.PREISACH else "a play readout"

    def laid(ratio: float) -> Plant:
        return lambda head: play_line.tip_mm(shipped.conduit, head, ratio)

    return Model(
        name,
        f"{kind} fitted to the real recording {shipped.recording}, {shipped.input} to jaw; degrees "
        "scaled to 120 mm of head travel",
        lambda _head, _tip: laid,
        in_class=False,
        floor_mm=shipped.scatter_mm,
        stroke=WHOLE_STROKE,
    )


def _rub(_head: Array, _tip: Array) -> Laid:
    chosen = play_line.RUBBING
    table = parameter.BENCH | transmission_parameter.rows(chosen)
    nominal = preset.transmission_of(parameter.nominal(table), chosen)
    still = nominal._replace(creep=nominal.creep._replace(fast_mm=0.0, slow_mm=0.0))

    def laid(ratio: float) -> Plant:
        conduit = transmission.widen(still, ratio)

        def plant(head: Array) -> Array:
            start = transmission.after_retract(conduit, float(head[0]))
            return transmission.simulate(conduit, start, head, DT_S)

        return plant

    return laid


FITTED = "fitted to the bench drawn by the seed"
MODELS = (
    Model("modified-dahl", "eqs. (3) and (4), the published parameters", _published),
    Model("bouc-wen", FITTED, _bouc_wen),
    Model("play", f"{FITTED}: one gap with corners", _play),
    _superposition("prandtl-ishlinskii", f"{FITTED}, plays of known widths"),
    _superposition("preisach", FITTED),
    _superposition("generalised", FITTED),
    Model(
        "bouc-wen-published",
        "the Bouc-Wen model with the paper's own parameters",
        lambda _head, _tip: _laid("bouc-wen", bouc_wen.PUBLISHED),
        in_class=False,
    ),
    *(_recorded(name) for name in conduit_file.NAMES),
    Model(
        "rubbing",
        "the nominal bench with less clearance, and behind it friction that depends on speed",
        _rub,
        in_class=False,
    ),
)
LEFT_OUT = (
    "Dahl is left out as a plant: its output is a force that saturates, so no head brings its tip "
    "90 mm down. With the missing line added it is the modified Dahl model."
)
PLANTS: tuple[Twin | Model, ...] = (*TWINS, *MODELS)
PLANT_OF_NAME = {plant.name: plant for plant in PLANTS}
NAMES = tuple(PLANT_OF_NAME)


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
