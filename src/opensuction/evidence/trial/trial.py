"""A trial: its parts spread over processes, each kept as soon as it is played."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from opensuction.evidence import worker_pool
from opensuction.evidence.trial import part, trial_log
from opensuction.evidence.trial.part import PlayedPart
from opensuction.evidence.trial.trial_log import Heading


class Standing(NamedTuple):
    """Progress of a trial."""

    cycles: int
    broken: int
    """Cycles in which something was broken, or said that is not so."""

    def with_part(self, played: PlayedPart) -> "Standing":
        """So far, with one part more."""
        return Standing(
            self.cycles + len(played.cases),
            self.broken + sum(case.is_broken for case in played.cases),
        )


class Listener(NamedTuple):
    """Callbacks on the progress of a trial; called from other threads, one call at a time."""

    tell: Callable[[Standing], None] = lambda _: None
    warn: Callable[[str], None] = lambda _: None
    """Of a process that died."""


NOBODY = Listener()


def list_found(parts: dict[int, PlayedPart]) -> list[PlayedPart]:
    """Parts in the order of their machines."""
    return [parts[machine] for machine in sorted(parts)]


def run(
    folder: Path,
    heading: Heading,
    kept: dict[int, PlayedPart],
    workers: int,
    listener: Listener = NOBODY,
) -> list[PlayedPart]:
    """Play what is left of a trial; all of its parts, in order.

    folder: has a log, which takes each part. kept: what it holds. What is compiled is compiled here
    first, and found by the processes in the cache. Raises OSError where the log cannot be written,
    WorkerLostError where process after process dies; what was kept stays.
    """
    parts = dict(kept)
    todo = [
        one for one in part.list_parts(heading.trial, heading.cycles) if one.machine not in parts
    ]
    if not todo:
        return list_found(parts)
    standing = Standing(0, 0)
    for one in kept.values():
        standing = standing.with_part(one)

    def note(_: int, played: PlayedPart) -> None:
        nonlocal standing
        trial_log.keep(folder, played)
        parts[played.machine] = played
        standing = standing.with_part(played)
        listener.tell(standing)

    part.warm_up(todo[0])
    listener.tell(standing)
    worker_pool.spread(part.play, todo, workers, note, listener.warn)
    return list_found(parts)
