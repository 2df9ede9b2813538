"""A cycle on the digital twin as a script runs it: the command's options in, columns out."""

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass
from operator import index
from os import PathLike, fspath
from pathlib import Path

from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.report.cycle import page
from opensuction.result.cycle_result import CycleResult
from opensuction.result.plain import Json, to_json
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import (
    cycle_run,
    cycle_summary,
    fault_run,
    resolution,
    summary_section,
    trace_file,
)
from opensuction.session.cycle.cycle_run import Prepared

LARGEST_SEED = 2**32 - 1
SHOWN = 3

Name = str | PathLike[str]
"""Of a preset, or the path of a TOML file."""


class Trace(dict[str, Array]):
    """Every tick of a run: a column by its name, shape (ticks,), all as doubles.

    A dictionary, so that `pandas.DataFrame` and `polars.DataFrame` take it as it is.
    """

    def __repr__(self) -> str:
        first = next(iter(self.values()))
        names = ", ".join(list(self)[:SHOWN])
        return f"Trace({first.size} ticks of {len(self)} columns: {names}, ...)"


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """One cycle that was played; `cycle` makes one."""

    result: CycleResult
    """What came of it: ``run.result.tip.deepest_mm``."""
    trace: Trace
    """Columns by name, a number for each millisecond: ``run.trace["time_s"]``."""
    prepared: Prepared
    """Machine, patient and protocol that were drawn and planned, as the rooms below have them."""

    @property
    def summary(self) -> Json:
        """The object of ``opensuction cycle --json``: ``run.summary["outcome"]``."""
        return to_json(self.result)

    @property
    def is_good(self) -> bool:
        """True if the cycle was completed and broke no bound for the patient."""
        return self.result.is_good

    def report(self, path: Name) -> None:
        """Write the report of the cycle, a single HTML page; a file that is there is replaced.

        Raises OSError where it cannot be written.
        """
        html = page.render(self.result, self.trace, summary_section.sections(self.prepared))
        Path(path).write_text(html, encoding="utf-8", errors="backslashreplace")

    def save_trace(self, path: Name, force: bool = False) -> None:
        """Write the trace as ``.csv`` or ``.parquet``, as ``opensuction cycle --trace`` does.

        force: replace a file that is there. Raises InputError for another ending, and for a file
        that is there; OSError where it cannot be written.
        """
        file = Path(path)
        trace_file.check(file, force)
        with trace_file.place(file) as aside:
            trace_file.fill(aside, self.trace)

    def __repr__(self) -> str:
        found = self.result
        who, seconds = found.patient or found.machine, found.timing.cycle_s
        return f"Run({who}, {found.outcome}, {seconds:.1f} s, seed {found.seed})"


def text(name: Name | None) -> str | None:
    """Name of a preset or path of a file, as the rooms below take it."""
    return None if name is None else fspath(name)


def checked_seed(seed: int) -> int:
    """A seed as the generators take it. Raises InputError for what is none of them."""
    seed = index(seed)
    if not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed {seed}: should be 0 to {LARGEST_SEED}")
    return seed


def cycle(  # noqa: PLR0913 - what the command takes, each by its name
    *,
    patient: Name | None = None,
    protocol: Name | None = None,
    approach: str = "travel",
    compensation: Name = "preview",
    machine: Name | None = None,
    catheter: str | None = None,
    conduit: str | None = None,
    seed: int = 1,
    faults: Sequence[str] = (),
    taught_mm: float | None = None,
    gap_scale: float = 1.0,
    preoxygenation: str | None = None,
) -> Run:
    """Run one suction cycle on the digital twin, as ``opensuction cycle`` does. In-silico.

    Every argument is the command's option of that name: ``opensuction cycle --help`` says what
    each takes, None is its default. faults: such as ``["line-leak=0.5", "power-lost@12"]``; one
    alone may stand without a list. taught_mm: ``--taught``.
    Raises InputError, with the command's own line, for unknown names, bad files, and what does
    not fit or cannot be planned.
    """
    began_s = clock.perf_counter()
    choice = CycleChoice(
        rig=RigChoice(text(machine), text(patient), catheter, conduit, checked_seed(seed)),
        protocol=text(protocol),
        approach=approach,
        compensation=fspath(compensation),
        taught_mm=taught_mm,
        faults=(faults,) if isinstance(faults, str) else tuple(faults),
        gap_scale=gap_scale,
        preoxygenation=preoxygenation,
    )
    prepared = cycle_run.oxygenate(cycle_run.prepare(resolution.resolve(choice)))
    found = fault_run.play(prepared, lambda _: None)
    result = cycle_summary.summary(prepared, found.columns, fault_run.on_record(found))
    result = cycle_summary.filed(result, clock.perf_counter() - began_s, None, None)
    return Run(result, Trace(found.columns), prepared)
