"""The identification of a machine of this kind: ``opensuction calibrate`` beside the one that runs.

On the twin the real-time signals have no laser on the tip, so the machine at the bed cannot find
its own transmission; a simulated one of the same kind, catheter and seed is excited in a process of
the lowest priority. What comes of it an engineer may accept, with a reason.

Acceptance of an identification: an engineer puts its result in force at the bedside.
"""

import atexit
import json
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, NamedTuple
from uuid import uuid4

import numpy as np

from opensuction.accounts.session import Session
from opensuction.console.access import ConsoleContext
from opensuction.console.guard.problem import Problem
from opensuction.console.setup import change, draft
from opensuction.console.setup.change import SettingsChange
from opensuction.control.compensation import CompensationKind
from opensuction.kernel import private_file
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import name_of
from opensuction.procedure.cycle.progress import HOME_MM
from opensuction.records.entry import SettingsFile
from opensuction.report.series import directions, keep_rows, to_list
from opensuction.session.calibration.calibration_file import PARAMETER_FILE, RECORDING_FILE
from opensuction.session.cycle import equipment
from opensuction.session.running.basis import Basis
from opensuction.settings import identification_file

FOLDER = "identification"
"""Where runs lie, beside the recordings."""
RESULT = "calibrate.json"
USUALLY_S = 60.0
"""How long a run takes on a computer that has little else to do [computed]."""
LONGEST_S = 900.0
"""After this it is ended."""
KEPT = 20
"""Runs that are remembered."""
BUCKETS = 300
"""Of the loop that is drawn: each keeps its extremes."""
JITTER_MM = 0.2
NICE = "import os; os.nice(19); from opensuction.cli.app import main; main()"
STAGES = ("Exciting the machine", "Exciting it again")
"""What the command tells, in order."""
MEASURED = (
    "In-silico: a simulated machine of this one's kind, catheter and seed was excited over its "
    "stroke, its tip under a simulated laser. The machine at the bed was not moved, and nothing "
    "was measured on it."
)


def check_simulated(site: ConsoleContext) -> None:
    """Refuse to simulate in place of a machine that is real; raises Problem 409."""
    if not site.about().machine.is_twin:
        raise Problem(
            409,
            "this machine is real, and a simulated one says nothing of its transmission: begin it "
            "with --compensation and a parameter file of its own",
        )


class IdentificationJob(NamedTuple):
    """One identification."""

    id: str
    by: str
    folder: Path
    process: subprocess.Popen[bytes]
    began_s: float
    command: tuple[str, ...]


class FoundCalibration(NamedTuple):
    """Result of ``calibrate``, as far as an engineer judges it here."""

    accepted: bool
    """Whether it wrote a parameter file."""
    reasons: tuple[str, ...]
    """Why it is refused, in sentences; empty where it is accepted."""
    gap_mm: float | None
    """Of the transmission; None where no model was found, so that nothing is accepted."""
    figures: dict[str, Any]
    """`FIGURES`, for the page to show as they are."""


class Runs:
    """Those of one console: one at a time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._runs: dict[str, IdentificationJob] = {}
        self._accepted: dict[str, str] = {}

    def list(self) -> list[IdentificationJob]:
        """All that are remembered, the newest first."""
        with self._lock:
            return list(reversed(self._runs.values()))

    def find(self, name: str) -> IdentificationJob:
        """Raises Problem 404."""
        with self._lock:
            found = self._runs.get(name)
        if found is None:
            raise Problem(404, "no such identification: those of an earlier console are forgotten")
        return found

    def begin(self, site: ConsoleContext, who: Session, basis: Basis) -> IdentificationJob:
        """Start one. Raises Problem 409 while another goes on."""
        with self._lock:
            if any(one.process.poll() is None for one in self._runs.values()):
                raise Problem(409, "an identification goes on already: wait for its end")
            name = uuid4().hex[:12]
            folder = site.recordings / FOLDER / name
            command = _command(basis, folder)
            try:
                private_file.make_folder(folder.parent)
                with private_file.create(folder.parent / f"{name}.log") as log:
                    process = subprocess.Popen(
                        [sys.executable, "-c", NICE, *command],
                        stdin=subprocess.DEVNULL,
                        stdout=subprocess.DEVNULL,
                        stderr=log,
                        umask=private_file.OTHERS,
                        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
                    )
            except OSError as error:
                raise Problem(503, f"it could not be started: {error.strerror}") from None
            found = IdentificationJob(name, who.account, folder, process, time.monotonic(), command)
            threading.Thread(target=_watch, args=(process,), daemon=True).start()
            self._runs[name] = found
            while len(self._runs) > KEPT:
                del self._runs[next(iter(self._runs))]
            return found

    def end(self) -> None:
        """Nobody waits for them any more."""
        for one in self.list():
            if one.process.poll() is None:
                one.process.kill()
                one.process.wait()

    def accepted_by(self, run: IdentificationJob) -> str | None:
        """Account that has accepted a run; None: nobody has."""
        return self._accepted.get(run.id)

    def accept(self, run: IdentificationJob, who: str) -> None:
        """Note that somebody has."""
        self._accepted[run.id] = who


RUNS = Runs()
"""Of this process."""
atexit.register(RUNS.end)


def _watch(process: subprocess.Popen[bytes]) -> None:
    """End a run that takes too long."""
    try:
        process.wait(LONGEST_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _command(basis: Basis, folder: Path) -> tuple[str, ...]:
    """Command line of a run, for the kind of machine at the bed."""
    kind = basis.compensation
    if kind == CompensationKind.NONE:
        kind = CompensationKind.PREVIEW
    words = ["calibrate", "--seed", str(basis.rig.seed), "--compensation", name_of(kind)]
    for name in ("machine", "patient", "catheter", "conduit"):
        value = getattr(basis.rig, name)
        if value is not None:
            words += [f"--{name}", value]
    return (*words, "--out", str(folder))


def shown(run: IdentificationJob) -> dict[str, Any]:
    """Progress of a run, and its result."""
    status = run.process.poll()
    elapsed_s = time.monotonic() - run.began_s
    told: dict[str, Any] = {
        "id": run.id,
        "by": run.by,
        "state": "running" if status is None else "failed",
        "stage": _stage(run) if status is None else "",
        "elapsed_s": elapsed_s,
        "usually_s": USUALLY_S,
        "detail": "",
        "measured": MEASURED,
        "accepted_by": RUNS.accepted_by(run),
        "result": None,
        "loop": None,
    }
    if status is None:
        return told
    result = result_of(run)
    if result is None:
        return {**told, "detail": _last_words(run) or f"it ended with status {status}"}
    loop = _loop(run.folder / RECORDING_FILE)
    state = "found" if result.accepted else "refused"
    detail = " ".join(result.reasons)
    return {**told, "state": state, "detail": detail, "result": result.figures, "loop": loop}


def _stage(run: IdentificationJob) -> str:
    text = _log(run)
    told = [stage for stage in STAGES if stage in text]
    return told[-1] if told else "Starting"


def _log(run: IdentificationJob) -> str:
    try:
        return (run.folder.parent / f"{run.id}.log").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _last_words(run: IdentificationJob) -> str:
    lines = _log(run).strip().splitlines()
    return lines[-1][:300] if lines else ""


def result_of(run: IdentificationJob) -> FoundCalibration | None:
    """Result of a run; None before its end, and where it found nothing."""
    try:
        found = json.loads((run.folder / RESULT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    match found:
        case {
            "accepted": bool(accepted),
            "reasons": list(reasons),
            "gap_mm": (float() | None) as gap_mm,
        } if gap_mm is not None or not accepted:
            figures = {name: found.get(name) for name in FIGURES}
            return FoundCalibration(accepted, tuple(map(str, reasons)), gap_mm, figures)
    return None


FIGURES = (
    "accepted",
    "machine",
    "patient",
    "catheter_mm",
    "seed",
    "compensation",
    "gap_mm",
    "gap_ratio",
    "parameters",
    "servo",
    "validation",
    "checks",
    "samples",
    "version",
    "date_utc",
)
"""What of a result is shown."""


def _loop(path: Path) -> dict[str, list[float | None]] | None:
    """Head and tip of the recording, thinned, with the direction of each row."""
    try:
        table = np.loadtxt(path, delimiter=",", skiprows=2, usecols=(0, 1, 2), ndmin=2)
    except (OSError, ValueError):
        return None
    if len(table) < 2:
        return None
    time_s, head, tip = (np.ascontiguousarray(table[:, i]) for i in range(3))
    inward = directions(head, JITTER_MM)
    rows = keep_rows([head, tip], [], BUCKETS)
    return {
        "time": to_list(time_s[rows], 2),
        "head": to_list(head[rows], 2),
        "tip": to_list(tip[rows], 2),
        "inward": to_list(inward[rows].astype(np.float64), 0),
    }


def shown_acceptance(site: ConsoleContext, run: IdentificationJob) -> dict[str, Any]:
    """Progress and result of a run, with the shift of the parked head if it is accepted.

    A head that is no longer where it is parked halts the machine, and a reset brings it there.
    """
    told = shown(run)
    shift_mm = halts = None
    if told["state"] == "found" and told["accepted_by"] is None:
        try:
            present = site.hub.configuration().settings.plan.motion
            _, following = _with(change.basis_of(site), run)
            motion = change.made(following, site.hub.configuration()).settings.plan.motion
        except (InputError, Problem):
            pass  # not to be said now; accepting it says why
        else:
            shift_mm = motion.park_head_mm - present.park_head_mm
            halts = abs(shift_mm) > motion.settle_mm + HOME_MM
    return {**told, "park_shift_mm": shift_mm, "halts": halts}


def accept(
    site: ConsoleContext, who: Session, run: IdentificationJob, reason: str, version: int, key: str
) -> Basis:
    """Have the machine go by what was found, with a reason. Raises as `change.carry_out`."""
    result = result_of(run)
    if run.process.poll() is None or result is None or not result.accepted:
        raise Problem(409, "nothing was found that could be accepted")
    with change.LOCK:
        if RUNS.accepted_by(run) is not None:
            raise Problem(409, "the machine goes by it already")
        found = change.basis_of(site)
        change.check_version(found, version)
        change.require_parked(change.now(site))
        file, following = _with(found, run)
        detail = f"{file.name} {file.sha256}; gap {result.gap_mm:.2f} mm; reason: {reason}"
        wanted = SettingsChange(who.account, key, "accept-calibration", detail, following, file)
        after = change.carry_out(site, wanted)
        RUNS.accept(run, who.account)
    return after


def _with(found: Basis, run: IdentificationJob) -> tuple[SettingsFile, Basis]:
    """The parameter file, and settings made with its model. Raises InputError, or Problem 422."""
    path = run.folder / PARAMETER_FILE
    identified = identification_file.load(path)
    kind = equipment.resolve(found.rig).machine
    calibration = equipment.calibration(identified, path.name, kind)
    name = f"calibration-{path.parent.name}.toml"
    following = found._replace(calibration=calibration, calibrated_by=f"accepted {name}")
    checked = draft.Draft(found.by_contact, found.site, found.protocol, ())
    if refused := draft.judge(following, checked):
        raise Problem(422, f"the protocol in force does not fit it: {refused[0].sentence}")
    try:
        return SettingsFile(name, path.read_text(encoding="utf-8")), following
    except OSError as error:
        raise InputError(f"{path.name} cannot be read: {error.strerror}") from None
