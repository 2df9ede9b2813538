"""Machine and patient files at the ends of what they accept, held against the bounds of harm."""

import typing
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from annotated_types import Ge, Gt, Le

from opensuction.controller.machine_profile import MachineProfile
from opensuction.kernel.errors import InputError
from opensuction.oracle import exposure, harm
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.twin import preset
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES

TWIN = preset.MACHINE_TABLES["clinical"]
FITTED = {"adult-icu": ("12fr", 150.0), "child-10kg": ("6fr", 110.0), "neonate": ("6fr", 90.0)}
"""Catheter and relief valve, mmHg, of a machine for a patient."""
NOT_ZERO = 1e-3
"""Share of a range's other end that stands for an end which is not itself accepted."""
APPROACHES = ("contact", "travel")


class Value(NamedTuple):
    section: str
    """`twin`, `controller`, or none for a key of a patient file."""
    key: str
    value: float


def twin_values() -> list[Value]:
    ends = ((key, end) for key, row in TWIN.items() for end in (row.low, row.high))
    return [Value("twin", key, end) for key, end in ends]


def controller_values() -> list[Value]:
    found = []
    for key, hint in typing.get_type_hints(MachineProfile, include_extras=True).items():
        marks = {type(mark): mark for mark in getattr(hint, "__metadata__", ())}
        if Le not in marks:
            continue
        most = float(marks[Le].le)
        least = float(marks[Ge].ge) if Ge in marks else float(marks[Gt].gt) + NOT_ZERO * most
        found += [Value("controller", key, end) for end in (least, most)]
    return found


def patient_values(name: str) -> list[Value]:
    rows = PATIENT_TABLES[name].items()
    return [Value("", key, end) for key, row in rows for end in (row.low, row.high)]


def machine_text(patient: str, value: Value) -> str:
    """A machine file that fits a patient but for one value."""
    catheter, relief_mmhg = FITTED[patient]
    sections = {name: {"relief_mmhg": relief_mmhg} for name in ("twin", "controller")}
    sections[value.section][value.key] = value.value
    lines = ['preset = "clinical"', f'catheter = "{catheter}"', 'conduit = "standard"']
    for name, keys in sections.items():
        lines += [f"[{name}]", *(f"{key} = {given}" for key, given in keys.items())]
    return "\n".join(lines)


def broken(rig: RigChoice, approach: str) -> list[str] | None:
    """Bounds that a cycle without a fault broke; None where the files are refused.

    A saturation that was too low before anything began is not counted.
    """
    try:
        choice = CycleChoice(rig, approach=approach)
        prepared = cycle_run.oxygenate(cycle_run.prepare(resolution.resolve(choice)))
        columns = cycle_run.play(prepared)
    except InputError:
        return None
    machine = prepared.rig.machine
    borne = exposure.measure(machine, columns)
    judged = harm.measure(machine, borne, prepared.loop.controller.limits.cap_mm)
    saturation = next(each for each in judged if each.name == harm.SATURATION)
    began_low = columns["truth.spo2_percent"][0] < saturation.limit
    return [
        f"{each.name} {each.worst:g} of {each.limit:g}"
        for each in judged
        if each.is_broken and not (each is saturation and began_low)
    ]


def judge(folder: Path, patient: str, value: Value) -> tuple[int, list[str]]:
    """How many of both approaches were played, and what was broken."""
    file = folder / "given.toml"
    if value.section:
        file.write_text(machine_text(patient, value), encoding="utf-8")
        rig = RigChoice(machine=str(file), patient=patient)
    else:
        file.write_text(f'preset = "{patient}"\n{value.key} = {value.value}\n', encoding="utf-8")
        rig = RigChoice(patient=str(file))
    found = [broken(rig, approach) for approach in APPROACHES]
    played = [each for each in found if each is not None]
    return len(played), [f"{patient}, {value}: {one}" for each in played for one in each]


@pytest.mark.parametrize("key", ["switch_n", "buckling_n", "post_buckling_ratio"])
def test_a_tip_at_the_ends_of_its_range_presses_with_no_more_than_it_may(
    tmp_path: Path, key: str
) -> None:
    """Before the force at the tip was estimated the first two reached .78 N of .3."""
    ends = (TWIN[key].low, TWIN[key].high)
    found = [judge(tmp_path, "adult-icu", Value("twin", key, end)) for end in ends]
    assert sum(played for played, _ in found) >= 2
    assert [one for _, bad in found for one in bad] == []


@pytest.mark.soak
@pytest.mark.parametrize("patient", FITTED)
def test_no_accepted_value_breaks_a_bound(tmp_path: Path, patient: str) -> None:
    values = [*twin_values(), *controller_values(), *patient_values(patient)]
    found = [judge(tmp_path, patient, value) for value in values]
    assert [one for _, bad in found for one in bad] == []
    assert np.mean([played > 0 for played, _ in found]) > 0.5
