"""The parameter file: what an identification found, in TOML, for people and for `cycle`.

It holds what was identified from which recording, so that every number has its origin. A
compensator takes its model from such a file (`to_calibration`), which refuses what does not fit.
"""

import re
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

import numpy as np
import tomli_w
from annotated_types import Ge, Gt

from opensuction.controller.calibration import PLAIN_PD, Calibration, Feedforward, assume_nominal
from opensuction.hysteresis.catalogue.catalogue import CATALOGUE
from opensuction.hysteresis.catalogue.duhem_family import MODIFIED_DAHL_FORM
from opensuction.hysteresis.catalogue.hysteresis_model import write_unit
from opensuction.hysteresis.modified_dahl import ModifiedDahl, is_monotone
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import NOT_A_DEVICE
from opensuction.settings import calibration_section, model_structure
from opensuction.settings.calibration_section import Lines, Measured
from opensuction.settings.model_structure import ModelPart, Structure
from opensuction.settings.toml_file import load_toml
from opensuction.settings.validation import choose, to_mapping, validate
from opensuction.settings.wording import name_source, one_line, refuse, unknown

FORMAT_VERSION: Final = 3
"""Raised with every change that older software would misread. 2: what a calibration measured. 3:
models of plays with lines over them, which drive."""

NO_COMPENSATOR: Final = "none"

ON_LINES: Final = "model-preview"
"""The compensator of every model that drives as plays with lines over them."""

COMPENSATORS: Final = {
    name: (ON_LINES,) if model.lines is not None else ("exact-inverse", "direct-inverse")
    for name, model in CATALOGUE.items()
    if not model.undriven
}
"""Compensators that can use a model alone, the one it is meant for first; other models drive no
head."""

COMPENSATOR_OF_MODEL: Final = {model: names[0] for model, names in COMPENSATORS.items()}

ON_MEASURED: Final = ("preview", "prandtl-ishlinskii", "gap-width", "lookup-table")
"""Compensators that need what only a calibration of the machine measures."""

*_MODEL, _INITIAL_LAG = MODIFIED_DAHL_FORM.parameters

MODIFIED_DAHL: Final = {
    parameter.name: (field, write_unit(parameter.unit, "mm", "mm"))
    for parameter, field in zip(_MODEL, ModifiedDahl._fields, strict=True)
}
"""Name in a file to field of `ModifiedDahl` and unit; the initial lag is of the recording alone."""

HEAD: Final = f"""\
# What `opensuction identify` or `opensuction calibrate` found. `opensuction cycle --compensation
# FILE` runs the compensator named here on it. Every parameter has its unit and, where one could be
# given, the interval that holds the true value with 95 % confidence (an empty list where not).
# {NOT_A_DEVICE}

"""

_INTERVAL: Final = re.compile(r"^ci95 = \[\n +(\S+),\n +(\S+),\n\]$", re.MULTILINE)
"""An interval as the writer lays it out, over four lines; one is easier to read."""

_SURROGATE: Final = re.compile("[\ud800-\udfff]")
"""Stands in the name of a file for a byte that is no UTF-8."""

_HASH: Final = re.compile(r"[0-9a-f]{64}")


class IdentifiedParameter(NamedTuple):
    """One identified parameter."""

    value: float
    unit: str
    ci95: list[float]
    """Lower and upper end; empty where no interval could be given."""


class Quantity(NamedTuple):
    """A recorded column as it was used."""

    column: str
    unit: str
    negated: bool
    lowest: float
    """Of the samples used; the model knows nothing beyond."""
    highest: float


class Source(NamedTuple):
    """The recording that was identified."""

    file: str
    sha256: str
    """Of the whole file."""
    samples: Annotated[int, Gt(0)]
    fitted_samples: Annotated[int, Gt(0)]
    """The rest was held out."""
    input: Quantity
    output: Quantity


class IdentificationFile(NamedTuple):
    """A parameter file, the values of its parameters aside."""

    format_version: Annotated[int, Ge(1)]
    software_version: str
    date_utc: datetime
    model: str
    method: str
    compensator: str
    """Which compensator is to use the model; ``none`` where there is none for it."""
    well_posed: bool
    """Whether the model has a continuous inverse."""
    rmse: Annotated[float, Ge(0)]
    rmse_unit: str
    rmse_percent_of_range: Annotated[float, Ge(0)]
    recording: Source
    undriven: str = ""
    """Why no compensator takes the model; empty where one does."""


class Identified(NamedTuple):
    """A whole parameter file."""

    about: IdentificationFile
    parameters: dict[str, IdentifiedParameter]
    servo: Feedforward | None
    """Servo feedforward of the same machine, which a person may add; None: plain PD."""
    measured: Measured | None = None
    """What only a calibration of the machine finds; None for a recording of one's own."""
    structure: tuple[Structure, ...] = ()
    """What the names of the parameters stand for, one for each input; none where they say all."""
    driven: Lines | None = None
    """The model of plays that drives the head; None where another one does."""
    nominal: ModifiedDahl | None = None
    """The modified Dahl model of the same recording, which the tip's bounds go by; None where it is
    the model itself."""


def to_toml(identified: Identified) -> str:
    """The file as TOML, which `load` reads back as the same record."""
    about, parameters, servo, measured, structure, driven, nominal = to_mapping(identified).values()
    content = {**about, "parameters": parameters}
    if structure:
        content["structure"] = structure
    sections = {"servo": servo, "modified_dahl": nominal, "driven": driven}
    content |= {name: section for name, section in sections.items() if section is not None}
    text = _INTERVAL.sub(r"ci95 = [\1, \2]", tomli_w.dumps(content | (measured or {})))
    # A file's name may hold what no UTF-8 is; in a string of TOML a backslash is written twice.
    return HEAD + _SURROGATE.sub(lambda found: rf"\\u{ord(found[0]):04x}", text)


def load(path: Path | str) -> Identified:
    """A parameter file from disk. Raises InputError of one line for anything that is not one."""
    content = load_toml(path)
    _check_version(content, path)
    parameters = content.pop("parameters", None)
    servo, driven = content.pop("servo", None), content.pop("driven", None)
    nominal = content.pop("modified_dahl", None)
    structure = content.pop("structure", [])
    measured = {name: content.pop(name) for name in Measured._fields if name in content}
    if not isinstance(parameters, Mapping) or not parameters:
        raise refuse(path, f"has no section parameters; {_REMEDY}")
    about = validate(IdentificationFile, content, path)
    if not _HASH.fullmatch(about.recording.sha256):
        raise refuse(path, "recording.sha256 is not a SHA-256 of 64 hexadecimal digits")
    return Identified(
        about=about,
        parameters={
            name: _parameter(entry, f"{path}: parameters.{name}")
            for name, entry in parameters.items()
        },
        servo=None if servo is None else validate(Feedforward, servo, f"{path}: servo"),
        measured=validate(Measured, measured, path) if measured else None,
        structure=_structure(structure, path),
        driven=None if driven is None else validate(Lines, driven, f"{path}: driven"),
        nominal=None
        if nominal is None
        else validate(ModifiedDahl, nominal, f"{path}: modified_dahl"),
    )


def _structure(given: object, path: Path | str) -> tuple[Structure, ...]:
    """The structure of each input. Raises InputError."""
    if not isinstance(given, list):
        raise refuse(path, f"structure should be a list of sections; {_REMEDY}")
    return tuple(validate(Structure, one, f"{path}: structure") for one in given)


def to_model(identified: Identified, path: Path | str) -> tuple[ModelPart, ...]:
    """The model of a parameter file, a part for each input: what was fitted, to the last bit.

    path: names the file in messages. Raises InputError for parameters that make no model.
    """
    values = {name: found.value for name, found in identified.parameters.items()}
    with name_source(path):
        return model_structure.rebuild(identified.about.model, values, identified.structure)


def input_names(identified: Identified) -> tuple[str, ...]:
    """Columns of the inputs that the model was fitted to, in their order."""
    names = tuple(one.column for one in identified.structure)
    return names or (identified.about.recording.input.column,)


def output_sign(identified: Identified) -> float:
    """Of the output as it was recorded, over that of the output as it was fitted."""
    return -1.0 if identified.about.recording.output.negated else 1.0


def predict(identified: Identified, parts: tuple[ModelPart, ...], inputs: Array) -> Array:
    """Output as it would be recorded, after what the fitted recording began after.

    parts: as `to_model` gives them. inputs: shape (inputs, samples). Returns shape (samples,).
    """
    output = np.zeros(inputs.shape[1])
    for part, row in zip(parts, inputs, strict=True):
        output += part.simulate(row)
    return output_sign(identified) * output


_REMEDY: Final = "give a file that opensuction identify or opensuction calibrate wrote"


def _check_version(content: Mapping[str, Any], path: Path | str) -> None:
    """Newer files first: what else they hold is not for this software to judge."""
    version = content.get("format_version")
    if isinstance(version, bool) or not isinstance(version, int):
        raise refuse(path, f"has no format_version, so it is no parameter file; {_REMEDY}")
    if version > FORMAT_VERSION:
        by = content.get("software_version", "a newer version")
        raise refuse(
            path,
            f"has format version {version}, written by opensuction {by}; this version reads up to "
            f"{FORMAT_VERSION}: update opensuction or identify again",
        )


def _parameter(entry: object, where: str) -> IdentifiedParameter:
    parameter = validate(IdentifiedParameter, entry, where)
    ends = parameter.ci95
    if ends and (len(ends) != 2 or not ends[0] <= parameter.value <= ends[1]):
        raise InputError(
            one_line(f"{where}.ci95 is {ends}; give a lower and an upper end around the value")
        )
    return parameter


def to_calibration(identified: Identified, path: Path | str) -> Calibration:
    """Calibration for a compensator: the model, the servo's feedforward, and measured sections.

    Of a file without measured sections every other model is the plain backlash of its model.

    Raises InputError for a model that no compensator uses, other units than millimetres, missing
    or surplus parameters, values a model cannot have, and a compensator that the model breaks.
    """
    about = identified.about
    known = _usable(identified, path)
    choose(about.compensator, dict.fromkeys(known), f"compensator for {about.model}, in {path},")
    _check_units(identified, path)
    if about.model != "modified-dahl":
        return _of_lines(identified, path)
    model = _modified_dahl(identified, path)
    if about.well_posed != is_monotone(model):
        raise refuse(
            path,
            f"says well_posed = {str(about.well_posed).lower()}, and its parameters say the "
            "opposite; identify again instead of changing values by hand",
        )
    if about.compensator == "direct-inverse" and not about.well_posed:
        raise refuse(
            path,
            f"the model has no continuous inverse (slope {model.slope:.4g} is not above twice the "
            f"velocity_gain, {2.0 * model.velocity_gain:.4g}), so direct-inverse would jump: set "
            'compensator to "exact-inverse", which crosses the reversal as a gap',
        )
    return _measured(assume_nominal(model, identified.servo or PLAIN_PD), identified, path)


def _usable(identified: Identified, path: Path | str) -> tuple[str, ...]:
    """Compensators that can use the file. Raises InputError where none can, with the reason."""
    about = identified.about
    known = COMPENSATORS.get(about.model)
    if known is None:
        entry = CATALOGUE.get(about.model)
        why = "which no compensator uses" if entry is None else f"and {entry.undriven}"
        raise refuse(
            path,
            f"holds the model '{about.model}', {why}; identify with --model "
            f"{' or '.join(COMPENSATORS)}",
        )
    if about.undriven:
        raise refuse(path, f"its {about.model} model drives no head: {about.undriven}")
    if identified.measured is not None:
        known = (*known, *ON_MEASURED)
    if identified.driven is not None and ON_LINES not in known:
        known = (*known, ON_LINES)
    return known


def _of_lines(identified: Identified, path: Path | str) -> Calibration:
    """The calibration of a model of plays; all else is the plain backlash of its modified Dahl."""
    driven, nominal = identified.driven, identified.nominal
    if driven is None or nominal is None:
        lacks = "driven" if driven is None else "modified_dahl"
        raise refuse(path, f"has no section {lacks}, by which a head is driven; {_REMEDY}")
    found = assume_nominal(nominal, identified.servo or PLAIN_PD)
    with name_source(path):
        return found._replace(lines=calibration_section.read(driven))


def _measured(found: Calibration, identified: Identified, path: Path | str) -> Calibration:
    """The calibration with its plays and curves as they were measured, where they were."""
    measured, depths = identified.measured, identified.about.recording.output
    if measured is None:
        return found
    with name_source(path):
        if identified.driven is not None:
            found = found._replace(lines=calibration_section.read(identified.driven))
        return found._replace(
            plays=calibration_section.read_plays(measured.plays, depths.lowest, depths.highest),
            width=calibration_section.read_curves(measured.gap_width, "gap_width"),
            table=calibration_section.read_curves(measured.lookup_table, "lookup_table"),
        )


def _check_units(identified: Identified, path: Path | str) -> None:
    recording = identified.about.recording
    for what, unit in (("input", recording.input.unit), ("output", recording.output.unit)):
        if unit != "mm":
            raise refuse(
                path,
                f"was identified with the {what} in {unit or 'no known unit'}; a compensator needs "
                "head and tip in mm",
            )
    if identified.about.rmse_unit != recording.output.unit:
        raise refuse(path, f"rmse_unit is '{identified.about.rmse_unit}', should be 'mm'")


def _modified_dahl(identified: Identified, path: Path | str) -> ModifiedDahl:
    given = identified.parameters
    for name in given:
        if name not in (*MODIFIED_DAHL, _INITIAL_LAG.name):
            raise refuse(path, unknown(f"key parameters.{name}", name, MODIFIED_DAHL))
    values = {}
    for name, (field, unit) in MODIFIED_DAHL.items():
        if name not in given:
            raise refuse(path, f"parameters.{name} is missing; {_REMEDY}")
        if given[name].unit != unit:
            raise refuse(
                path, f"parameters.{name}.unit is '{given[name].unit}', should be '{unit}'"
            )
        values[field] = given[name].value
    return validate(ModifiedDahl, values, f"{path}: parameters")
