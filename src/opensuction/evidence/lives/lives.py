"""Many lives, one a seed: spread over processes, summed up, and any of them played again."""

import gc
import hashlib
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import NamedTuple

from opensuction import __version__
from opensuction.evidence import worker_pool
from opensuction.evidence.lives import life
from opensuction.evidence.lives.life import INVARIANTS, LifeEvent, LifeResult
from opensuction.evidence.lives.life_fault import Kind, LifeFault
from opensuction.evidence.lives.record_judge import BrokenInvariant

SECONDS_PER_H = 3600.0


class PlayedLife(NamedTuple):
    """One life."""

    seed: int
    machine_seed: int
    """Draws machine and patient."""
    faults: tuple[str, ...]
    """As `LifeFault.title` writes them."""
    violations: tuple[BrokenInvariant, ...]
    fewest: tuple[str, ...]
    """Fewest of its faults that still break something; empty where nothing is broken."""
    steps: int
    """Of all processes."""
    simulated_s: float
    trace: str
    """Hash of all steps in their order, and of the truth: the same seed gives the same."""
    events: tuple[LifeEvent, ...]
    """Course of the life."""


class LivesResult(NamedTuple):
    """Lives of a whole machine under a simulated clock."""

    version: str
    """Of the software; a seed means the same life in the same version alone."""
    in_silico: bool
    lives: int
    first_seed: int
    kinds: tuple[str, ...]
    """Kinds of faults that were drawn."""
    invariants: Mapping[str, str]
    """Conditions that had to hold in each life."""
    broken: tuple[PlayedLife, ...]
    """Lives in which something did not hold."""
    simulated_h: float
    trace: str
    """Hash of the lives' traces in the order of their seeds."""
    wall_s: float
    """Duration of the command."""
    ok: bool


def run(
    seeds: range,
    kinds: tuple[Kind, ...],
    workers: int,
    tell: Callable[[int, LifeResult], None] = lambda *_: None,
    warn: Callable[[str], None] = lambda _: None,
) -> list[LifeResult]:
    """Play the lives of some seeds, in as many processes as there are workers.

    tell: hears of each with its number among the seeds. warn: see `worker_pool.spread`.
    """
    return worker_pool.spread(partial(_play, kinds=kinds), seeds, workers, tell, warn)


@cache
def _settle() -> None:
    """Leave what was there before the first life out of each life's collection: it stays."""
    gc.freeze()


def _play(seed: int, kinds: tuple[Kind, ...]) -> LifeResult:
    _settle()
    return life.play(life.draw(seed, kinds))


def shrink(broken: LifeResult) -> tuple[LifeFault, ...]:
    """Fewest faults of a life that still break one of the same invariants, one left out in turn."""
    wanted = {one.invariant for one in broken.violations}
    kept = broken.life.faults
    for fault in broken.life.faults:
        fewer = tuple(one for one in kept if one is not fault)
        found = life.play(broken.life._replace(faults=fewer))
        if wanted & {one.invariant for one in found.violations}:
            kept = fewer
    return kept


def to_played(found: LifeResult) -> PlayedLife:
    """A life as it is reported; one that broke something is shrunk."""
    fewest = shrink(found) if found.violations else ()
    return PlayedLife(
        found.life.seed,
        found.life.machine_seed,
        tuple(one.title for one in found.life.faults),
        found.violations,
        tuple(one.title for one in fewest),
        found.steps,
        round(found.simulated_s, 3),
        found.trace,
        found.events,
    )


def to_result(
    seeds: range, kinds: tuple[Kind, ...], found: list[LifeResult], wall_s: float
) -> LivesResult:
    """Result of lives that were played."""
    traces = " ".join(one.trace for one in found)
    broken = tuple(to_played(one) for one in found if one.violations)
    return LivesResult(
        version=__version__,
        in_silico=True,
        lives=len(found),
        first_seed=seeds.start,
        kinds=tuple(map(str, kinds)),
        invariants=dict(INVARIANTS),
        broken=broken,
        simulated_h=round(sum(one.simulated_s for one in found) / SECONDS_PER_H, 4),
        trace=hashlib.sha256(traces.encode()).hexdigest()[: life.TRACE],
        wall_s=round(wall_s, 1),
        ok=not broken,
    )
