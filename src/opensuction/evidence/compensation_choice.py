"""The compensation that a person chose: a name, or a parameter file that holds name and model."""

from opensuction.control.compensation import KIND_OF_NAME, CompensationKind
from opensuction.controller.setup import Calibration
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.settings import identification_file, plausibility
from opensuction.settings.choice import choose
from opensuction.settings.identification_file import Identified

SUFFIX = ".toml"
"""How the path of a parameter file ends; no compensator's name does."""


def chosen(name: str) -> tuple[CompensationKind, Identified | None]:
    """The compensator that was named, and the parameter file where one was given.

    Raises InputError for an unknown name and for a file whose model no compensator can use.
    """
    if not name.endswith(SUFFIX):
        return choose(name, KIND_OF_NAME, "compensation"), None
    identified = identification_file.load(name)
    identification_file.calibration(identified, name)
    return KIND_OF_NAME[identified.about.compensator], identified


def calibration(identified: Identified, name: str, nominal: ModifiedDahl) -> Calibration:
    """Calibration of a parameter file, held against the machine that it is to drive.

    name: path of the file, for messages. nominal: the machine's transmission as it was built.
    Raises InputError for a model that cannot be this machine's.
    """
    found = identification_file.calibration(identified, name)
    plausibility.check(found.model, nominal, name)
    return found
