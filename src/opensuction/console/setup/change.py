"""Other settings for the machine that runs: made, put on record, and taken by it at rest.

One after the other: who changes what somebody else has changed meanwhile is told so. Nothing is
done that is not on record first; what the machine made of it its own journal says.
"""

import contextlib
import json
import threading
from pathlib import Path
from typing import NamedTuple

from opensuction.console.guard.problem import FieldError, Problem
from opensuction.console.setup import bedside
from opensuction.console.site import ConsoleContext
from opensuction.control.compensation import CompensationKind
from opensuction.controller import configuration, setup
from opensuction.controller.configuration import Configuration
from opensuction.ipc.mailbox import SET_PROTOCOL
from opensuction.kernel import private_file
from opensuction.kernel.codegen import document
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning import teaching_limit
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.procedure.planning.protocol import Protocol
from opensuction.records.entry import Action, SettingsFile
from opensuction.runtime import control_process, controller_request, machine_identity, paths
from opensuction.runtime.loop import SET
from opensuction.runtime.machine_identity import About
from opensuction.session.running import basis as bases
from opensuction.session.running.basis import Basis

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
        protocol = teaching_limit.protocol(chosen.site.age, teaching_limit.IDLE_VACUUM_MMHG)
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
    text = json.dumps(document.write(Protocol, chosen.protocol), indent=1, sort_keys=True)
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
    bedside.require_parked(bedside.now(site))
    folder, key = site.folder, change.key
    following = change.basis._replace(version=change.basis.version + 1)
    chosen = made(following, _present(folder))
    record(site, change.who, change.what, change.detail, key)
    files = [folder / control_process.settings_file(key)]
    files += [folder / control_process.beside(name, key) for name in control_process.TOGETHER]
    try:
        private_file.write(files[0], configuration.to_json(chosen))
        machine_identity.write(folder, _about(site, change), files[1].name)
        bases.write(folder, following, files[2].name)
        verdict = bedside.ask(folder, SET_PROTOCOL, change.who, key)
    except OSError as error:
        raise Problem(503, f"the settings could not be written: {error.strerror}") from None
    # Without an answer they stay: the controller may just be reading them.
    if verdict != SET:
        for file in files:
            file.unlink(missing_ok=True)
        with contextlib.suppress(InputError):
            record(site, change.who, f"{change.what}-refused", verdict, key)
        raise Problem(409, controller_request.explain(verdict))
    return following


def _present(folder: Path) -> Configuration:
    try:
        text = (folder / paths.CONFIGURATION).read_text(encoding="utf-8")
        return configuration.from_json(text)
    except (OSError, UnicodeDecodeError, InputError) as error:
        raise Problem(503, f"the settings in force cannot be read: {error}") from None
