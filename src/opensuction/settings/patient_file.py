"""A patient file: the preset it starts from, which also gives the age, and what it changes.

preset = "adult-icu"
weight_kg = 82.0                                # not drawn
carina_mm = { value = 60.0, spread = 4.0 }      # drawn by the seed
"""

from collections.abc import Mapping
from os import PathLike

from opensuction.kernel.errors import InputError
from opensuction.settings.choice import choose
from opensuction.settings.parameter_section import change
from opensuction.settings.toml_file import load_toml
from opensuction.settings.wording import name_source, refuse
from opensuction.twin.behaviour.behaviour_parameter import ROWS, SWITCH
from opensuction.twin.parameter_row import Parameter
from opensuction.twin.patient import patient_kind
from opensuction.twin.patient.patient_kind import PatientKind
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES


def _refuse_idle(table: Mapping[str, Parameter], given: Mapping[str, object]) -> None:
    """Refuse what a quiet patient would never do; raises InputError."""
    if given.get(SWITCH, table[SWITCH].value) != 0.0:
        return
    for name in given:
        if name in ROWS and name != SWITCH:
            raise InputError(
                f"{name} is given, but {SWITCH} is 0, so that the patient does nothing of it; "
                f"give {SWITCH} = 1 too"
            )


def load(path: str | PathLike[str]) -> PatientKind:
    """The kind of patient that a file describes.

    Raises InputError of one line for a file that cannot be read, an unknown or missing key, a value
    out of its range, and values that do not fit together, with the arithmetic.
    """
    given = load_toml(path)
    if "preset" not in given:
        raise refuse(path, f"preset is missing; give one of {', '.join(PATIENT_TABLES)}")
    name = given.pop("preset")
    with name_source(path):
        choose(name, PATIENT_TABLES, "preset")
        start = patient_kind.of_preset(name)
        _refuse_idle(start.table, given)
        kind = start._replace(table=change(start.table, given, "", path))
        patient_kind.check(kind)
    return kind
