"""Many lives, one a seed: spread over processes, summed up, and any of them played again."""

import gc
import hashlib
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

from opensuction import __version__
from opensuction.evidence import worker_pool
from opensuction.evidence.lives import life, simulated_machine
from opensuction.evidence.lives.life_fault import Kind, LifeFault
from opensuction.evidence.lives.life_record import LifeEvent, LifeResult
from opensuction.evidence.lives.record_judge import INVARIANTS, BrokenInvariant
from opensuction.kernel.errors import InputError

SECONDS_PER_H = 3600.0


class PlayedLife(NamedTuple):
    """One life."""

    id: str
    """Seed and version of the software, as `--play` takes it: ``4711@1.0.0``."""
    play: str
    """Command that plays it again."""
    seed: int
    machine_seed: int
    """Draws machine and patient."""
    faults: tuple[str, ...]
    """As `LifeFault.title` writes them."""
    violations: tuple[BrokenInvariant, ...]
    fewest: tuple[str, ...]
    """Fewest of its faults that still break something; empty where nothing is broken, and where the
    campaign ended before they were looked for."""
    steps: int
    """Of all processes."""
    simulated_s: float
    trace: str
    """Hash of all steps in their order, and of the truth: the same seed gives the same."""
    events: tuple[LifeEvent, ...]
    """Course of the life."""
    recordings: tuple[str, ...]
    """Files of its recorders beside this one; none in a campaign."""


class LivesResult(NamedTuple):
    """Lives of a whole machine under a simulated clock."""

    version: str
    """Of the software; a seed means the same life in the same version alone."""
    in_silico: bool
    lives: int
    """Those that were played."""
    asked: int
    """Those that were wanted."""
    complete: bool
    """These are all: nobody interrupted the campaign, and nothing ended it early."""
    first_seed: int
    kinds: tuple[str, ...]
    """Kinds of faults that were drawn."""
    cycles: int
    """Of each life, one after the other."""
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


class Campaign(NamedTuple):
    """Lives that are wanted."""

    seeds: range
    kinds: tuple[Kind, ...] = tuple(Kind)
    workers: int = 1
    cycles: int = 1
    """Of each life."""


def make_id(seed: int) -> str:
    """Identifier of a life: its seed, and the version in which the seed means this life."""
    return f"{seed}@{__version__}"


def read_id(given: str) -> int:
    """Seed of a life by its identifier, or by its seed alone.

    Raises InputError for one of another version, in which the seed meant another life.
    """
    seed, is_of, version = given.partition("@")
    if not (seed.isascii() and seed.isdecimal()) or (is_of and not version):
        raise InputError(
            f"--play {given}: give a seed from 0 on, or seed and version as a report has them, "
            f"such as 4711 or {make_id(4711)}"
        )
    if is_of and version != __version__:
        raise InputError(
            f"--play {given}: this is version {__version__}, which draws another life from the "
            f"seed {seed} than {version} did; --play {int(seed)} plays that one"
        )
    return int(seed)


def run(
    campaign: Campaign,
    tell: Callable[[int, LifeResult], None] = lambda *_: None,
    warn: Callable[[str], None] = lambda _: None,
) -> list[LifeResult]:
    """Play the lives of a campaign, in as many processes as it has workers.

    tell: hears of each with its number among the seeds. warn: see `worker_pool.spread`. Raises
    InputError where the memory has no space for them.
    """
    with simulated_machine.room() as room:
        play = partial(_play, campaign=campaign, room=room)
        return worker_pool.spread(play, campaign.seeds, campaign.workers, tell, warn)


@cache
def _settle() -> None:
    """Leave what was there before the first life out of each life's collection: it stays."""
    gc.freeze()


def _play(seed: int, campaign: Campaign, room: Path) -> LifeResult:
    _settle()
    return life.play(life.draw(seed, campaign.kinds, campaign.cycles), room)


def shrink_all(
    found: Sequence[LifeResult], workers: int, warn: Callable[[str], None] = lambda _: None
) -> dict[int, tuple[LifeFault, ...]]:
    """Fewest faults of each life that broke something, by its seed; see `run`."""
    broken = [one for one in found if one.violations]
    with simulated_machine.room() as room:
        fewest = worker_pool.spread(partial(shrink, room=room), broken, workers, warn=warn)
    return {one.life.seed: faults for one, faults in zip(broken, fewest, strict=True)}


def shrink(broken: LifeResult, room: Path | None = None) -> tuple[LifeFault, ...]:
    """Fewest faults of a life that still break one of the same invariants, one left out in turn."""
    wanted = {one.invariant for one in broken.violations}
    kept = broken.life.faults
    for fault in broken.life.faults:
        fewer = tuple(one for one in kept if one is not fault)
        found = life.play(broken.life._replace(faults=fewer), room)
        if wanted & {one.invariant for one in found.violations}:
            kept = fewer
    return kept


def to_played(
    found: LifeResult,
    kinds: tuple[Kind, ...] = tuple(Kind),
    fewest: tuple[LifeFault, ...] = (),
    recordings: tuple[str, ...] = (),
) -> PlayedLife:
    """A life as it is reported. kinds: those that its faults were drawn from."""
    which = make_id(found.life.seed)
    drawn = "" if kinds == tuple(Kind) else f" --faults {','.join(kinds)}"
    if found.life.cycles > 1:
        drawn += f" --cycles {found.life.cycles}"
    return PlayedLife(
        which,
        f"opensuction simulate --play {which}{drawn}",
        found.life.seed,
        found.life.machine_seed,
        tuple(one.title for one in found.life.faults),
        found.violations,
        tuple(one.title for one in fewest),
        found.steps,
        round(found.simulated_s, 3),
        found.trace,
        found.events,
        recordings,
    )


def to_result(
    campaign: Campaign,
    found: Sequence[LifeResult],
    fewest: Mapping[int, tuple[LifeFault, ...]],
    wall_s: float,
) -> LivesResult:
    """Result of a campaign, or of as much of it as was played.

    found: in the order of their seeds. fewest: by the seed, as far as they were looked for.
    """
    traces = " ".join(one.trace for one in found)
    broken = tuple(
        to_played(one, campaign.kinds, fewest.get(one.life.seed, ()))
        for one in found
        if one.violations
    )
    return LivesResult(
        version=__version__,
        in_silico=True,
        lives=len(found),
        asked=len(campaign.seeds),
        complete=len(found) == len(campaign.seeds),
        first_seed=campaign.seeds.start,
        kinds=tuple(map(str, campaign.kinds)),
        cycles=campaign.cycles,
        invariants=dict(INVARIANTS),
        broken=broken,
        simulated_h=round(sum(one.simulated_s for one in found) / SECONDS_PER_H, 4),
        trace=hashlib.sha256(traces.encode()).hexdigest()[: life.TRACE],
        wall_s=round(wall_s, 1),
        ok=not broken,
    )
