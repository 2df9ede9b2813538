"""Parts of a campaign on disk: a campaign that was cut off goes on where it was.

A part is kept under the hash of the core's sources: cases of other sources are other cases.
"""

from collections.abc import Callable
from pathlib import Path

from pydantic import ConfigDict, TypeAdapter

from opensuction.evidence import crew
from opensuction.evidence.trial import fault_campaign
from opensuction.evidence.trial.fault_campaign import Case, Part
from opensuction.kernel.compiled import sources_hash

CASES = TypeAdapter(list[Case], config=ConfigDict(ser_json_inf_nan="constants"))
"""Cases as JSON, and back."""


def path(folder: Path, part: Part) -> Path:
    """Where a part is kept; part and sources are in the name."""
    name = "-".join(str(value) for value in part)
    return folder / sources_hash() / f"{name}.json"


def keep(folder: Path, part: Part, cases: list[Case]) -> None:
    """Keep a part that was played; written whole or not at all."""
    file = path(folder, part)
    file.parent.mkdir(parents=True, exist_ok=True)
    beside = file.with_suffix(".part")
    beside.write_bytes(CASES.dump_json(cases))
    beside.replace(file)


def kept(folder: Path, part: Part) -> list[Case] | None:
    """Cases of a part that was played before; None where there are none."""
    file = path(folder, part)
    if not file.exists():
        return None
    return CASES.validate_json(file.read_bytes())


def _parts(whole: Part, size: int) -> list[Part]:
    firsts = range(whole.first, whole.last, size)
    return [whole._replace(first=at, last=min(at + size, whole.last)) for at in firsts]


def spread(
    folder: Path,
    whole: Part,
    workers: int,
    size: int = 500,
    tell: Callable[[int], None] = lambda _: None,
) -> list[Case]:
    """The same cases as `fault_campaign.played_part`, over processes of their own.

    folder: keeps each part as soon as it is played; what is there already is not played again.
    size: cycles of a part. tell: called with how many cycles are there. What is compiled is
    compiled here first, and found by the processes in the cache.
    """
    found = {part: kept(folder, part) for part in _parts(whole, size)}
    open_parts = [part for part, cases in found.items() if cases is None]
    if open_parts:
        fault_campaign.played_part(open_parts[0]._replace(last=open_parts[0].first + 1))

    def note(number: int, cases: list[Case]) -> None:
        found[open_parts[number]] = cases
        keep(folder, open_parts[number], cases)
        tell(sum(len(cases) for cases in found.values() if cases is not None))

    crew.spread(fault_campaign.played_part, open_parts, workers, note)
    return [case for cases in found.values() if cases is not None for case in cases]
