"""Other settings for the machine that runs: made, put on record, and taken by it at rest.

One after the other: who changes what somebody else has changed meanwhile is told so. Nothing is
done that is not on record first; what the machine made of it its own journal says.

The machine as set-up needs it: its present state, from its newest row, and its buttons.
"""

import contextlib
import json
import threading
import time
from pathlib import Path
from typing import NamedTuple

from opensuction.console.access import ConsoleContext
from opensuction.console.guard.problem import FieldError, Problem
from opensuction.control.compensation import CompensationKind
from opensuction.controller import configuration, setup
from opensuction.controller.configuration import Configuration
from opensuction.ipc.mailbox import SET_PROTOCOL
from opensuction.kernel import private_file
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.procedure.cycle.teaching import SENTENCES, Taught
from opensuction.procedure.planning import guideline
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.procedure.planning.protocol import Protocol
from opensuction.records.entry import Action, SettingsFile
from opensuction.runtime import control_process, launch, machine_folder
from opensuction.runtime.loop import ROW_COLUMNS, SET
from opensuction.runtime.machine_folder import About
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
        verdict = launch.ask(folder, what, who, key, ANSWERS_S)
    except (InputError, OSError) as error:
        raise Problem(503, f"no controller takes requests now: {error}") from None
    if verdict is None:
        raise Problem(503, "the controller does not answer; the bedside view shows what it does")
    return verdict


def press(folder: Path, button: str, who: str, key: str) -> None:
    """Press a button. Raises Problem 409 where the loop refuses it."""
    verdict = ask(folder, button, who, key)
    if verdict != launch.PRESSED:
        raise Problem(409, launch.explain(verdict))


LOCK = threading.Lock()
"""Held by who changes something."""
APPROACHES = {False: "travel", True: "contact"}


class SettingsChange(NamedTuple):
    """Change of the settings that a person asks for."""

    who: str
    key: str
    what: str
    """As the action is on record."""
    detail: str
    basis: Basis
    """The next one, its version still that of the present one."""
    parameter_file: SettingsFile | None = None
    """Another one; None: as it is."""


def check_version(found: Basis, version: int) -> None:
    """Raises Problem 409 where somebody else has changed it meanwhile."""
    if found.version != version:
        raise Problem(
            409,
            "somebody else has changed the settings meanwhile: look at what is in force now, then "
            "save again what you still want",
            [FieldError("version", f"in force is version {found.version}, yours is {version}")],
        )


def record(site: ConsoleContext, who: str, what: str, detail: str, key: str) -> None:
    """Put on record what somebody is about to do. Raises RecordsError where that cannot be."""
    machine = site.about().machine
    site.records.note_machine(machine)
    site.records.act(Action(who, what, detail[:2000], machine.serial), f"{what}-{key}"[:64])


def made(chosen: Basis, present: Configuration) -> Configuration:
    """The settings. present: whose schedule and rests go on. Raises InputError."""
    kind, calibration = chosen.compensation, chosen.calibration
    if chosen.is_teaching:
        kind = CompensationKind.EXACT_INVERSE
        protocol = guideline.protocol(chosen.site.age, guideline.IDLE_VACUUM_MMHG)
    else:
        protocol = chosen.protocol
    by_contact = chosen.by_contact and not chosen.is_teaching
    found = setup.settings(chosen.profile, protocol, kind, calibration, by_contact, chosen.site)
    before = present.settings.service
    service = found.service._replace(schedule=before.schedule, passes=before.passes)
    found = found._replace(service=service)
    if chosen.is_teaching:
        most_s = GUIDELINES[chosen.site.age].in_airway_s
        found = found._replace(
            limits=found.limits._replace(in_airway_s=most_s),
            plan=found.plan._replace(travel_known=False),
        )
    return Configuration(found, setup.branches(kind, calibration))


def _about(site: ConsoleContext, change: SettingsChange) -> About:
    """Description of the machine after the change."""
    found, chosen = site.about(), change.basis
    text = json.dumps(plain_row.write(Protocol, chosen.protocol), indent=1, sort_keys=True)
    approach = APPROACHES[chosen.by_contact]
    heading = {**found.heading, "protocol": chosen.protocol_name, "approach": approach}
    return found._replace(
        protocol=SettingsFile(chosen.protocol_name, text),
        approach=approach,
        parameter_file=change.parameter_file or found.parameter_file,
        heading=heading,
    )


def carry_out(site: ConsoleContext, change: SettingsChange) -> Basis:
    """Have the machine go by other settings; returns what is in force then. `LOCK` is held.

    Raises InputError for settings that cannot be, Problem where the machine does not take them,
    RecordsError where it cannot be put on record: then nothing was changed.
    """
    require_parked(now(site))
    folder, key = site.folder, change.key
    following = change.basis._replace(version=change.basis.version + 1)
    chosen = made(following, _present(folder))
    record(site, change.who, change.what, change.detail, key)
    files = [folder / control_process.settings_file(key)]
    files += [folder / control_process.beside(name, key) for name in control_process.TOGETHER]
    try:
        private_file.write(files[0], configuration.to_json(chosen))
        machine_folder.write(folder, _about(site, change), files[1].name)
        bases.write(folder, following, files[2].name)
        verdict = ask(folder, SET_PROTOCOL, change.who, key)
    except OSError as error:
        raise Problem(503, f"the settings could not be written: {error.strerror}") from None
    # Without an answer they stay: the controller may just be reading them.
    if verdict != SET:
        for file in files:
            file.unlink(missing_ok=True)
        with contextlib.suppress(InputError):
            record(site, change.who, f"{change.what}-refused", verdict, key)
        raise Problem(409, launch.explain(verdict))
    return following


def _present(folder: Path) -> Configuration:
    try:
        text = (folder / machine_folder.CONFIGURATION).read_text(encoding="utf-8")
        return configuration.from_json(text)
    except (OSError, UnicodeDecodeError, InputError) as error:
        raise Problem(503, f"the settings in force cannot be read: {error}") from None
