"""Bounds for the patient that a run broke; empty where it broke none.

`measure` returns for each bound how near the run came to it, `find` those that were broken.

The cause is not judged: a saturation that falls for the patient's own reasons is listed as any
other.

A run of any length before its judge: many stays in the airway, each with bounds of its own.

The bounds are those of one cycle: what a patient may bear before there has been time to recover.
So a long run is cut where the tip has been out for `APART_S`, from the truth alone: whether it was
a cycle that ended there, a withdrawal by the drives or a recovery is no question here. Stays that
follow each other faster are one, and their times are summed.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.oracle import exposure
from opensuction.oracle.exposure import (
    ADVANCE_MM,
    BOUNDS,
    CLOSING_S,
    COLUMNS,
    FORCE_N,
    PatientExposure,
    Ticks,
)
from opensuction.twin.machine.machine import Machine


class Harm(NamedTuple):
    """A bound, and how near to it or how far beyond it a patient came."""

    name: str
    """One of `NAMES`."""
    worst: float
    limit: float
    unit: str
    """Of both."""

    @property
    def is_broken(self) -> bool:
        """True where the worst value is beyond the limit."""
        if self.name == SATURATION:
            return self.worst < self.limit
        return self.worst > self.limit


LEFT_INSIDE = "left-inside"
TIP_PAST_CAP = "tip-past-cap"
FORCE = "force"
CONTACT_TIME = "contact-time"
VACUUM = "vacuum"
SUCTION_TIME = "suction-time"
AIRWAY_TIME = "airway-time"
ADVANCE = "advance-under-vacuum"
AIRWAY_PRESSURE = "airway-pressure"
LUNG_VOLUME = "lung-volume"
SATURATION = "saturation"

NAMES = (
    LEFT_INSIDE,
    TIP_PAST_CAP,
    FORCE,
    CONTACT_TIME,
    VACUUM,
    SUCTION_TIME,
    AIRWAY_TIME,
    ADVANCE,
    AIRWAY_PRESSURE,
    LUNG_VOLUME,
    SATURATION,
)
"""Every bound by name, the most urgent first."""


def deepest_mm(machine: Machine, cap_mm: float) -> float:
    """Greatest depth of the tip: its cap, and no further past the carina than force presses it.

    A tip that is further past it is in a bronchus. cap_mm: deepest position that was planned.
    """
    return min(cap_mm, machine.airway.carina_mm + FORCE_N / machine.airway.tip.carina_n_per_mm)


def _depth(machine: Machine, borne: PatientExposure, cap_mm: float) -> Harm:
    """Past its cap, or past the carina where that was at the same instant."""
    if borne.deepest_mm > cap_mm:
        return Harm(TIP_PAST_CAP, borne.deepest_mm, deepest_mm(machine, cap_mm), "mm")
    reached_mm = machine.airway.carina_mm + borne.past_carina_mm
    return Harm(TIP_PAST_CAP, reached_mm, deepest_mm(machine, math.inf), "mm")


def _rest(borne: PatientExposure) -> Harm:
    """The catheter at the end, or a piece of it."""
    if borne.piece_mm > 0.0 and not borne.inside_at_end:
        return Harm(LEFT_INSIDE, borne.piece_mm, 0.0, "mm")
    worst_mm = borne.end_mm if borne.inside_at_end else min(borne.end_mm, borne.outside_mm)
    return Harm(LEFT_INSIDE, worst_mm, borne.outside_mm, "mm")


def _of_machine(machine: Machine, borne: PatientExposure, cap_mm: float) -> tuple[Harm, ...]:
    """Bounds that hold on the bench, too."""
    force = Harm(FORCE, borne.force_peak_n, FORCE_N, "N")
    return _rest(borne), _depth(machine, borne, cap_mm), force


def _of_patient(machine: Machine, borne: PatientExposure) -> tuple[Harm, ...]:
    """Bounds that need a patient."""
    person = machine.patient
    bounds = BOUNDS[AgeGroup(person.age_group)]
    return (
        Harm(CONTACT_TIME, borne.contact_s, bounds.contact_s, "s"),
        Harm(VACUUM, borne.vacuum_peak_mmhg, bounds.vacuum_mmhg, "mmHg"),
        Harm(SUCTION_TIME, borne.suction_s, bounds.suction_s + CLOSING_S, "s"),
        Harm(AIRWAY_TIME, borne.in_airway_s, bounds.in_airway_s, "s"),
        Harm(ADVANCE, borne.advance_mm, ADVANCE_MM, "mm"),
        Harm(AIRWAY_PRESSURE, borne.pressure_unsafe_s, bounds.pressure_s, "s"),
        Harm(
            LUNG_VOLUME,
            borne.lung_volume_loss_ml,
            bounds.lung_loss_ml_per_kg * person.weight_kg,
            "mL",
        ),
        Harm(SATURATION, borne.spo2_least_percent, bounds.spo2_percent, "%"),
    )


def measure(machine: Machine, borne: PatientExposure, cap_mm: float) -> tuple[Harm, ...]:
    """Every bound, broken or not, in the order of `NAMES`; arguments as of `find`."""
    found = _of_machine(machine, borne, cap_mm)
    return (*found, *_of_patient(machine, borne)) if machine.has_patient else found


def find(machine: Machine, borne: PatientExposure, cap_mm: float) -> tuple[Harm, ...]:
    """Bounds that were broken, in the order of `NAMES`.

    machine: as it was built, before any fault. borne: of the whole run. cap_mm: deepest tip
    position that was planned; infinite where none was.
    """
    return tuple(one for one in measure(machine, borne, cap_mm) if one.is_broken)


APART_S = 10.0
"""[assumed] With the airway free for so long a patient has had two breaths even at 12 a minute.
Saturation and lung volume, which take longer, are judged by how low they are, however many stays
have led there."""
REST_S = 60.0
"""A rest is judged in pieces of this length, so that what is kept of it does not grow."""


class Judged(NamedTuple):
    """A piece of a run, from one rest to the next."""

    first_s: float
    last_s: float
    """Its first and its last tick."""
    borne: PatientExposure
    harm: tuple[Harm, ...]


def worst(runs: Sequence[Judged]) -> tuple[Harm, ...]:
    """Every bound that was broken in any of them, with the worst that it came to.

    A tip that was inside where a piece ended has been left there only if it is the last one.
    """
    found: dict[str, Harm] = {}
    for place, run in enumerate(runs):
        for one in run.harm:
            passing = one.name == LEFT_INSIDE and run.borne.inside_at_end
            if passing and place + 1 < len(runs):
                continue
            kept = found.get(one.name)
            if kept is None or abs(one.worst - one.limit) > abs(kept.worst - kept.limit):
                found[one.name] = one
    return tuple(found[name] for name in NAMES if name in found)


class LongRun:
    """Takes the truth as it comes, and keeps no more of it than its present piece."""

    def __init__(self, machine: Machine, cap_mm: float) -> None:
        """machine: as it was built, before any fault. cap_mm: deepest planned tip position."""
        self._machine, self._cap_mm = machine, cap_mm
        self._outside_mm: float | None = None
        self._parts: list[dict[str, Array]] = []
        self._first_s = math.nan
        """First tick of the present piece."""
        self.last_inside_s = -math.inf
        """Last tick with the tip in the airway; -inf before there was one."""
        self._done: list[Judged] = []

    def add(self, truth: Mapping[str, Array]) -> None:
        """Take the truth of the next ticks: columns by name, at least `exposure.COLUMNS`."""
        left = {name: np.array(truth[name]) for name in COLUMNS}
        while left["time_s"].size:
            if self._outside_mm is None:
                self._outside_mm = exposure.outside_mm(self._machine, left["truth.tip_mm"])
            if not self._parts:
                self._first_s = float(left["time_s"][0])
            inside = left["truth.tip_mm"] > self._outside_mm
            end = self._find_end(left["time_s"], inside)
            part = {name: column[:end] for name, column in left.items()}
            if inside[:end].any():
                self.last_inside_s = float(part["time_s"][inside[:end]][-1])
            self._parts.append(part)
            left = {name: column[end:] for name, column in left.items()}
            if left["time_s"].size:
                self.begin()

    def begin(self) -> None:
        """Judge all that comes from now on apart from what was."""
        if self._parts:
            self._done.append(self._judge())
        self._parts = []

    @property
    def runs(self) -> tuple[Judged, ...]:
        """Judgements so far, piece by piece."""
        return (*self._done, self._judge()) if self._parts else tuple(self._done)

    def _find_end(self, time_s: Array, inside: Ticks) -> int:
        """Number of these ticks that belong to the present piece."""
        known_s = self.last_inside_s if self.last_inside_s >= self._first_s else -math.inf
        last_s = np.maximum(np.maximum.accumulate(np.where(inside, time_s, -math.inf)), known_s)
        rested = np.where(
            last_s >= self._first_s, time_s - last_s > APART_S, time_s - self._first_s > REST_S
        )
        over = np.flatnonzero(rested)
        return int(over[0]) if over.size else int(time_s.size)

    def _judge(self) -> Judged:
        truth = {name: np.concatenate([part[name] for part in self._parts]) for name in COLUMNS}
        borne = exposure.measure(self._machine, truth)
        time_s = truth["time_s"]
        found = find(self._machine, borne, self._cap_mm)
        return Judged(float(time_s[0]), float(time_s[-1]), borne, found)
