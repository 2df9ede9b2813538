"""Acceptance of an identification: an engineer puts its result in force at the bedside."""

from typing import Any

from opensuction.accounts.session import Session
from opensuction.console.guard.problem import Problem
from opensuction.console.setup import bedside, change, draft, machine_identification
from opensuction.console.setup.change import SettingsChange
from opensuction.console.setup.machine_identification import RUNS, IdentificationJob
from opensuction.console.site import ConsoleContext
from opensuction.kernel.errors import InputError
from opensuction.procedure.cycle.progress import HOME_MM
from opensuction.records.entry import SettingsFile
from opensuction.session.calibration.calibration_file import PARAMETER_FILE
from opensuction.session.cycle import compensation_choice, equipment
from opensuction.session.running.basis import Basis
from opensuction.settings import identification_file


def shown(site: ConsoleContext, run: IdentificationJob) -> dict[str, Any]:
    """Progress and result of a run, with the shift of the parked head if it is accepted.

    A head that is no longer where it is parked halts the machine, and a reset brings it there.
    """
    told = machine_identification.shown(run)
    shift_mm = halts = None
    if told["state"] == "found" and told["accepted_by"] is None:
        try:
            present = site.hub.configuration().settings.plan.motion
            _, following = _with(bedside.basis_of(site), run)
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
    result = machine_identification.result_of(run)
    if run.process.poll() is None or result is None or not result.accepted:
        raise Problem(409, "nothing was found that could be accepted")
    with change.LOCK:
        if RUNS.accepted_by(run) is not None:
            raise Problem(409, "the machine goes by it already")
        found = bedside.basis_of(site)
        change.check_version(found, version)
        bedside.require_parked(bedside.now(site))
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
    calibration = compensation_choice.calibration(identified, path.name, kind)
    name = f"calibration-{path.parent.name}.toml"
    following = found._replace(calibration=calibration, calibrated_by=f"accepted {name}")
    checked = draft.Draft(found.by_contact, found.site, found.protocol, ())
    if refused := draft.judge(following, checked):
        raise Problem(422, f"the protocol in force does not fit it: {refused[0].sentence}")
    try:
        return SettingsFile(name, path.read_text(encoding="utf-8")), following
    except OSError as error:
        raise InputError(f"{path.name} cannot be read: {error.strerror}") from None
