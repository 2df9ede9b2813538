"""The page of all parameters is what the code runs on."""

import pytest

from docs.generator.catalogue import DOCS
from opensuction.controller import machine_profile
from opensuction.procedure.planning import clinical, guideline, protocol
from opensuction.twin.machine.catheter import CATHETERS, ROUTES
from opensuction.twin.parameter import BENCH
from opensuction.twin.patient.patient_parameter import ROWS

TEXT = (DOCS / "reference" / "parameters.md").read_text(encoding="utf-8")
TABLES = [line for line in TEXT.splitlines() if line.startswith("| `")]
NESTED = ("excitation", "transmission")
"""Records in the profile that no file sets."""


@pytest.mark.parametrize(
    "names",
    [
        BENCH,
        ROWS,
        CATHETERS,
        ROUTES,
        protocol.Protocol._fields,
        clinical.Template._fields,
        guideline.Guideline._fields,
        [name for name in machine_profile.MachineProfile._fields if name not in NESTED],
    ],
)
def test_every_parameter_has_its_line_with_a_source(names: list[str]) -> None:
    for name in names:
        lines = [line for line in TABLES if line.startswith(f"| `{name}` |")]
        assert lines, name
        for line in lines:
            assert len(line.split(" | ")[-1].removesuffix(" |").strip()) >= 3, line


def test_every_row_has_as_many_cells_as_its_header() -> None:
    cells = 0
    for line in TEXT.splitlines():
        if line.startswith("|---"):
            cells = line.count("|")
        elif line.startswith("| `"):
            assert line.count("|") == cells, line


def test_every_source_of_a_preset_belongs_to_a_value() -> None:
    assert set(protocol.PAPER_SOURCES) == set(protocol.Protocol._fields)
    assert set(clinical.TEMPLATE_SOURCES) == set(clinical.Template._fields)
    assert set(clinical.TEMPLATE_MEANINGS) == set(clinical.Template._fields)
    changed = {
        name
        for name in machine_profile.SOURCES
        if getattr(machine_profile.CLINICAL, name) != getattr(machine_profile.BENCH, name)
    }
    assert set(machine_profile.CLINICAL_SOURCES) == changed
