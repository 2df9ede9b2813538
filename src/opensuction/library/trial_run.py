"""A trial on the digital twin as a script runs it: many cycles, each judged by the twin's truth."""

import tempfile
import time as clock
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from operator import index
from pathlib import Path

from opensuction.evidence import worker_pool
from opensuction.evidence.trial import trial as played_trial
from opensuction.evidence.trial import trial_page, trial_summary
from opensuction.evidence.trial.trial_summary import Effort
from opensuction.kernel.errors import InputError
from opensuction.library.columns import in_python
from opensuction.library.run import Name, checked_seed
from opensuction.result.plain import Json, to_json
from opensuction.result.trial_result import FaultCount, PatientEndpoints, Trial, TrialResult


@dataclass(frozen=True, eq=False, repr=False)
class TrialRun:
    """A trial that was played; `trial` makes one. In-silico."""

    result: TrialResult
    """What came of it: ``found.result.bounds.patient.single.upper_percent``."""

    @property
    def summary(self) -> Json:
        """The object of ``opensuction trial --json``: ``found.summary["violations"]``."""
        return to_json(self.result)

    @property
    def is_good(self) -> bool:
        """True if every claim held; of two faults at once nothing is claimed."""
        return trial_summary.is_good(self.result)

    @property
    def endpoints(self) -> Mapping[str, PatientEndpoints]:
        """By patient: median, 5th and 95th percentile of each endpoint."""
        return self.result.endpoints

    def report(self, path: Name) -> None:
        """Write the page of the trial, Markdown; a file that is there is replaced.

        Raises OSError where it cannot be written.
        """
        page = trial_page.markdown(self.result)
        Path(path).write_text(page, encoding="utf-8", errors="backslashreplace")

    def __repr__(self) -> str:
        found = self.result
        patient = found.bounds.patient
        broken = sum(one.broken for one in (found.bounds.commands, *patient))
        return (
            f"TrialRun({found.cycles} cycles, faults {found.trial.faults}, {broken} bounds broken, "
            f"{found.false_alarms} false alarms, {found.left_inside.total.count} left inside)"
        )


def trial(
    cycles: int,
    *,
    faults: FaultCount = "single",
    cohort: str = "presets",
    seed: int = 1,
    compensation: str = "preview",
    preoxygenation: str = "confirmed",
    workers: int | None = None,
) -> TrialRun:
    """Play many cycles of the digital twin, as ``opensuction trial`` does. In-silico.

    cycles: 1 or more; the first of a longer trial are those of a shorter one. faults: of each
    cycle, ``none``, ``single`` or ``double``. The other arguments are the command's options of that
    name. workers: processes that share the cycles; None: one for each processor core. Nothing is
    left on disk: for a trial of hours, which may have to go on later, take the command.

    Raises InputError, in one line, for unknown names and numbers that cannot be meant, and
    `evidence.worker_pool.WorkerLostError` where process after process dies.
    """
    cycles, seed = index(cycles), checked_seed(seed)
    workers = worker_pool.count_cores() if workers is None else index(workers)
    for name, value in (("cycles", cycles), ("workers", workers)):
        if value < 1:
            raise InputError(f"{name} {value}: should be 1 or more")
    chosen = Trial(faults, cohort, seed, compensation, preoxygenation)
    began_s = clock.perf_counter()
    with in_python(), tempfile.TemporaryDirectory(prefix="opensuction-") as folder:
        played_trial.check(chosen)
        heading = played_trial.make_heading(chosen, cycles)
        played_trial.begin(Path(folder), heading)
        parts = played_trial.run(Path(folder), heading, {}, workers)
    wall_s = clock.perf_counter() - began_s
    effort = Effort(workers, wall_s, cycles, f"{datetime.now(tz=UTC):%Y-%m-%d}")
    return TrialRun(trial_summary.summarise(heading, parts, effort))
