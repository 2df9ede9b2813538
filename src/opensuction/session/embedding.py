"""Settings of a controller that somebody's own loop will call, from the names that a cycle takes.

Nothing is drawn, identified or taught on the twin: the machine is theirs. What it is like comes
from a machine file or a preset as it is built, its transmission from a parameter file or the
machine's nominal values, the travel length from whoever measured it.
"""

from opensuction.controller import setup
from opensuction.controller.configuration import Configuration
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning.clinical import Template
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, equipment, resolution
from opensuction.session.cycle.cycle_run import CONTACT_CARINA_MM
from opensuction.simulation import rig as rigs

NOMINAL_SEED = 1
"""Of a machine that nothing is drawn of."""


def controller_settings(
    *,
    machine: str | None = None,
    patient: str | None = None,
    catheter: str | None = None,
    protocol: str | None = None,
    approach: str = "travel",
    compensation: str = "preview",
    taught_mm: float | None = None,
) -> Configuration:
    """Settings for `Controller`, from the names and files that `opensuction cycle` takes.

    machine, patient, protocol: a preset's name or the path of a TOML file; only the bench has no
    patient. catheter: a size;
    the one for the patient's age without it. approach: ``travel`` or ``contact``.
    compensation: a compensator, or the path of a parameter file that names one and holds the
    model of this very machine; with a name alone the machine's nominal transmission is taken.
    taught_mm: from the tube's lower end to the carina as it was measured in this patient. A
    protocol is fitted to it, or held against it where it names its own travel; a bench takes none.
    Raises InputError for names, files and numbers that are not known or do not fit.
    """
    choice = CycleChoice(
        rig=RigChoice(machine=machine, patient=patient, catheter=catheter),
        protocol=protocol,
        approach=approach,
        compensation=compensation,
        taught_mm=taught_mm,
    )
    resolved = resolution.resolve(choice)
    if not resolved.equipment.on_bench and patient is None:
        raise InputError("patient: a machine at a patient needs one: give a preset or a file")
    if not resolved.equipment.on_bench and taught_mm is None:
        is_template = isinstance(resolved.protocol, Template)
        what = "fitted to the patient" if is_template else "held against the patient's depth"
        raise InputError(
            f"protocol '{resolved.protocol_name}' is {what}: give taught_mm, the length from the "
            "tube's lower end to the carina"
        )
    used = resolved.equipment
    rig = rigs.rig_of(used.machine, used.patient, NOMINAL_SEED, nominal=True)
    if resolved.by_contact and not rig.machine.has_patient:
        rig = rigs.with_carina(rig, CONTACT_CARINA_MM)
    if taught_mm is not None:
        rig = cycle_run.with_depth(rig, taught_mm)
    calibration = rigs.uncalibrated(rig.profile)
    if resolved.parameter_file is not None:
        calibration = equipment.calibration(resolved.parameter_file, compensation, rig.kind)
    kind = resolved.compensation
    fitted = cycle_run.fit(resolved, rig, calibration)
    settings = setup.settings(rig.profile, fitted, kind, calibration, resolved.by_contact, rig.site)
    return Configuration(settings, setup.branches(kind, calibration))
