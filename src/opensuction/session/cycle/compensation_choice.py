"""The compensation that a person chose: a name, or a parameter file that holds name and model."""

from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.controller.calibration import Calibration, Feedforward
from opensuction.controller.machine_profile import MachineProfile
from opensuction.kernel.errors import InputError
from opensuction.session.choice import LISTED
from opensuction.session.cycle.equipment import is_file
from opensuction.settings import identification_file, plausibility
from opensuction.settings.calibration_section import CalibratedMachine
from opensuction.settings.choice import choose
from opensuction.settings.identification_file import Identified
from opensuction.simulation.machine_kind import MachineKind

SAME_CATHETER_MM = 0.01
"""Outer diameters nearer than this are the same catheter: sizes are a third of a mm apart."""


def resolve(name: str) -> tuple[CompensationKind, Identified | None]:
    """The compensator that was named, and the parameter file where one was given.

    Raises InputError for an unknown name and for a file whose model no compensator can use.
    """
    if not is_file(name):
        return choose(name, KIND_OF_NAME, "compensation", LISTED), None
    identified = identification_file.load(name)
    identification_file.to_calibration(identified, name)
    return KIND_OF_NAME[identified.about.compensator], identified


def calibration(identified: Identified, name: str, kind: MachineKind) -> Calibration:
    """Calibration of a parameter file, held against the machine that it is to drive.

    name: path of the file, for messages. kind: what the machine was built as.
    Raises InputError for a model that cannot be this machine's, and for a machine that was
    calibrated as another kind or with another catheter.
    """
    found = identification_file.to_calibration(identified, name)
    if identified.servo is None:
        found = found._replace(feedforward=nominal_feedforward(kind.profile))
    if identified.measured is not None:
        _check_origin(identified.measured.machine, name, kind)
    plausibility.check(found, kind.profile.transmission, name)
    return found


def nominal_feedforward(profile: MachineProfile) -> Feedforward:
    """Feedforward by the motor's nominal speed; only a calibration measures friction."""
    return Feedforward(
        velocity_v_s_per_mm=profile.supply_v / profile.no_load_mm_per_s, friction_v=0.0
    )


def _check_origin(origin: CalibratedMachine, name: str, kind: MachineKind) -> None:
    if origin.preset != kind.preset:
        raise InputError(
            f"{name}: was calibrated on a {origin.preset} machine, and this one is {kind.preset}; "
            "calibrate the machine itself"
        )
    if abs(origin.catheter_mm - kind.catheter.outer_mm) > SAME_CATHETER_MM:
        raise InputError(
            f"{name}: was calibrated with a catheter of {origin.catheter_mm:.2f} mm, and this "
            f"machine has one of {kind.catheter.outer_mm:.2f} mm; calibrate it with that catheter"
        )
