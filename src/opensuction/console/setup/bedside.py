"""The machine as set-up needs it: its present state, from its newest row, and its buttons."""

import time
from pathlib import Path
from typing import NamedTuple

from opensuction.console.guard.problem import Problem
from opensuction.console.site import ConsoleContext
from opensuction.kernel.errors import InputError
from opensuction.kernel.name import name_of
from opensuction.kernel.phase import Phase
from opensuction.procedure.cycle.teaching import SENTENCES, Taught
from opensuction.runtime import controller_request
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.session.running import basis as bases
from opensuction.session.running.basis import Basis

ANSWERS_S = 2.0
"""Longest wait for an answer: other settings are taken up in some ticks."""
STALE_S = 0.5
"""An older row says nothing of now."""
_PHASE, _TAUGHT, _TAUGHT_MM, _AWAY, _BRINGING, _AGE, _HEAD, _INSIDE = (
    ROW_COLUMNS.index(name)
    for name in (
        "outputs.phase",
        "state.core.procedure.teaching.taught",
        "state.core.procedure.teaching.taught_mm",
        "state.core.procedure.teaching.away",
        "state.core.procedure.teaching.bringing",
        "state.core.upkeep.catheter_age_s",
        "inputs.readings.head_mm",
        "state.core.governor.watch.durations.inside_s",
    )
)


class Now(NamedTuple):
    """The machine now."""

    phase: Phase
    taught: Taught
    taught_mm: float | None
    """None where nothing was taken."""
    is_away: bool
    """The head has left home in this teaching."""
    is_bringing: bool
    """The drive brings it home."""
    catheter_age_s: float
    head_mm: float
    inside_s: float
    """How long the catheter has been in the patient."""

    @property
    def phase_name(self) -> str:
        """As the interface names it."""
        return name_of(self.phase)

    @property
    def taught_sentence(self) -> str:
        """Result of the last confirmation, as a sentence."""
        return SENTENCES[self.taught]


def now(site: ConsoleContext) -> Now:
    """Raises Problem 503 where the controller does not say."""
    newest = site.hub.newest()
    if newest is None or time.monotonic() - float(newest[1][0]) > STALE_S:
        raise Problem(503, "the controller does not run: what the machine does is not known")
    row = newest[1]
    taught = Taught(int(row[_TAUGHT]))
    return Now(
        phase=Phase(int(row[_PHASE])),
        taught=taught,
        taught_mm=float(row[_TAUGHT_MM]) if taught == Taught.TAKEN else None,
        is_away=bool(row[_AWAY]),
        is_bringing=bool(row[_BRINGING]),
        catheter_age_s=float(row[_AGE]),
        head_mm=float(row[_HEAD]),
        inside_s=float(row[_INSIDE]),
    )


def basis_of(site: ConsoleContext) -> Basis:
    """Basis of the machine's settings. Raises Problem 503 where there is none."""
    try:
        return bases.read(site.folder)
    except InputError as error:
        raise Problem(503, str(error)) from None


def require_parked(found: Now) -> None:
    """Raises Problem 409 for a machine that does something, or waits for something else."""
    if found.phase != Phase.PARKED:
        raise Problem(
            409, f"only while the machine is parked, and it is {found.phase_name.replace('-', ' ')}"
        )


def ask(folder: Path, what: str, who: str, key: str) -> str:
    """The loop's verdict on a request. Raises Problem 503 where no controller answers."""
    try:
        verdict = controller_request.ask(folder, what, who, key, ANSWERS_S)
    except (InputError, OSError) as error:
        raise Problem(503, f"no controller takes requests now: {error}") from None
    if verdict is None:
        raise Problem(503, "the controller does not answer; the bedside view shows what it does")
    return verdict


def press(folder: Path, button: str, who: str, key: str) -> None:
    """Press a button. Raises Problem 409 where the loop refuses it."""
    verdict = ask(folder, button, who, key)
    if verdict != controller_request.PRESSED:
        raise Problem(409, controller_request.explain(verdict))
