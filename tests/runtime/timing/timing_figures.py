"""Figures of a `timing_run`, and the effects of missed ticks by the twin's truth.

The judge of harm is `oracle`: it does not know ticks, phases or the controller's estimates.
"""

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase
from opensuction.oracle import exposure, harm
from opensuction.safety.condition import Condition
from opensuction.simulation.closed_loop import DT_S
from opensuction.twin.machine.machine import Machine
from tests.runtime.timing.timing_run import TimingRun

US = 1e6
EDGES_US = (10, 20, 30, 50, 75, 100, 150, 200, 300, 500, 1000, 2000, 5000, 10_000, 100_000)
"""Between the bins of the histograms; what is longer is counted last."""
SETTLED = 0.1
SETTLED_LOOKS = 10
"""Share of a run, and least number of looks, after which memory must have come to rest."""


class Spread(NamedTuple):
    """Of one time in all ticks, microseconds."""

    median_us: float
    p99_us: float
    p99_9_us: float
    most_us: float
    histogram: dict[str, int]
    """Ticks from one edge to the next, by the upper one."""


class Missed(NamedTuple):
    """Ticks that were not done."""

    ticks: int
    """That were."""
    missed: int
    percent: float
    """Of all that should have been."""


class Figures(NamedTuple):
    """What came of a run."""

    period_ms: float
    seconds: float
    scheduler: str
    refusals: str
    computed: Spread
    late: Spread
    """From its deadline until a tick began; of one that was not missed less than a period."""
    loop: Missed
    bare: Missed
    longest_gap_ms: float
    """Between the deadlines of two ticks that were done."""
    cycles_done: int
    cycles_broken_off: int
    tripped: tuple[str, ...]
    """Every trip that there was."""
    late_trips: int
    """How often too many late ticks were one."""
    alone_s: float
    """For how long the drives acted by themselves."""
    harms: tuple[str, ...]
    """Bounds that were broken, in all cycles."""
    airway_s: float
    """In the longest cycle."""
    deepest_mm: float
    cap_mm: float
    vacuum_mmhg: float
    resident_kb: tuple[int, int, int]
    """At the beginning, once it had settled, and the most from then on."""
    load: float
    stolen_percent: float


def spread(times_s: Array) -> Spread:
    """Of times in seconds."""
    found = times_s * US
    median, p99, p99_9 = np.percentile(found, (50.0, 99.0, 99.9))
    counts = np.histogram(found, (-np.inf, *EDGES_US, np.inf))[0]
    names = [*(f"{edge}" for edge in EDGES_US), "more"]
    histogram = {name: int(count) for name, count in zip(names, counts, strict=True)}
    return Spread(float(median), float(p99), float(p99_9), float(found.max()), histogram)


def missed(ticks: int, skipped: int) -> Missed:
    """Of so many that were done and so many that were not."""
    return Missed(ticks, skipped, 100.0 * skipped / (ticks + skipped))


def unexplained(run: TimingRun) -> list[float]:
    """Instants before which two or more periods were missed in a row, but for the computer's own.

    The computer explains them where it kept a core from everybody for all but one of them.
    """
    ticks, found = run.ticks, []
    for at in np.flatnonzero(ticks["loop.skipped"] > 1):
        missed_s = ticks["loop.skipped"][at] * ticks["inputs.dt_s"][at]
        ends_s = ticks["loop.time_s"][at] + ticks["loop.late_s"][at]
        least_s = missed_s - ticks["inputs.dt_s"][at]
        kept_s = [
            (np.minimum(one[:, 1], ends_s) - np.maximum(one[:, 0], ends_s - 2.0 * missed_s))
            .clip(0.0)
            .sum()
            for one in run.stood_s
        ]
        if max(kept_s, default=0.0) < least_s:
            found.append(float(ends_s))
    return found


def _starts(holds: Array) -> int:
    """How often something begins to hold."""
    return int(np.count_nonzero(np.diff(holds.astype(np.int8), prepend=0) > 0))


def _stays(machine: Machine, truth: dict[str, Array]) -> list[dict[str, Array]]:
    """The truth in parts, a stay in the airway each: from outside to outside, all that there is."""
    inside = exposure.find_inside(machine, truth["truth.tip_mm"])
    came_out = np.flatnonzero(inside[:-1] & ~inside[1:])
    # Each ends in the middle of the time outside: the line may still hold vacuum right behind it.
    went_in = np.flatnonzero(~inside[:-1] & inside[1:])
    cuts = [
        (out + int(went_in[went_in > out][0])) // 2 for out in came_out if (went_in > out).any()
    ]
    edges = [0, *cuts, len(inside)]
    return [
        {name: column[first:last] for name, column in truth.items()}
        for first, last in pairwise(edges)
    ]


def judge(run: TimingRun) -> tuple[tuple[str, ...], list[exposure.PatientExposure]]:
    """Every bound that was broken in any stay, and what the patient bore in each.

    A run may end in the midst of a cycle: a tip that is inside then is not left there.
    """
    machine, cap_mm = run.loop.machine, run.loop.controller.limits.cap_mm
    truth = {**run.truth, "time_s": run.truth["tick"] * DT_S}
    stays = _stays(machine, truth)
    borne = [exposure.measure(machine, stay) for stay in stays]
    found: list[str] = []
    for number, one in enumerate(borne):
        ends = number == len(borne) - 1
        found += [
            broken.name
            for broken in harm.find(machine, one, cap_mm)
            if not (ends and broken.name == harm.LEFT_INSIDE)
        ]
    return tuple(found), borne


def find(run: TimingRun) -> Figures:
    """All of them."""
    ticks, skipped = run.ticks, run.ticks["loop.skipped"]
    phase, trips = ticks["outputs.phase"], ticks["outputs.verdict.trips"].astype(np.int64)
    harms, borne = judge(run)
    done = (phase[:-1] == Phase.CLOSING) & (phase[1:] == Phase.PARKED)
    settled = max(round(len(run.resident_kb) * SETTLED), SETTLED_LOOKS)
    tripped = int(np.bitwise_or.reduce(trips))
    return Figures(
        period_ms=float(ticks["inputs.dt_s"][0]) * 1e3,
        seconds=float(ticks["loop.time_s"][-1] - ticks["loop.time_s"][0]),
        scheduler=str(run.began["scheduler"]),
        refusals=str(run.began["refusals"]),
        computed=spread(ticks["loop.computed_s"]),
        late=spread(ticks["loop.late_s"]),
        loop=missed(len(phase), int(skipped.sum())),
        bare=missed(run.bare["ticks"], run.bare["missed"]),
        longest_gap_ms=float(np.diff(ticks["loop.time_s"]).max()) * 1e3,
        cycles_done=int(np.count_nonzero(done)),
        cycles_broken_off=_starts(phase == Phase.ABORTING),
        tripped=tuple(one.name for one in Condition if tripped >> one & 1),
        late_trips=_starts(trips >> Condition.LATE_TICKS & 1 == 1),
        alone_s=float(np.count_nonzero(run.truth["alone"])) * DT_S,
        harms=harms,
        airway_s=max(one.in_airway_s for one in borne),
        deepest_mm=max(one.deepest_mm for one in borne),
        cap_mm=run.loop.controller.limits.cap_mm,
        vacuum_mmhg=max(one.vacuum_peak_mmhg for one in borne),
        resident_kb=(
            run.resident_kb[0],
            max(run.resident_kb[:settled]),
            max(run.resident_kb[settled:]),
        ),
        load=float(np.mean(run.load)),
        stolen_percent=run.stolen_percent,
    )


def to_json(figures: Figures) -> dict[str, Any]:
    """As an object of JSON."""
    flat = figures._asdict()
    for name in ("computed", "late", "loop", "bare"):
        flat[name] = flat[name]._asdict()
    return {name: round_(value) for name, value in flat.items()}


def round_(value: Any) -> Any:
    """To what was measured."""
    if isinstance(value, dict):
        return {name: round_(one) for name, one in value.items()}
    if isinstance(value, float) and math.isfinite(value):
        return round(value, 4)
    return value
