"""Settings for one's own loop, from names: those of a cycle, with nothing drawn of the twin."""

from pathlib import Path
from typing import Any

import pytest

from opensuction import InputError, controller_settings
from opensuction.control.compensation import CompensationKind
from opensuction.controller import configuration, setup
from opensuction.controller.configuration import Configuration
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.interface import START
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.interlocks import NEW_CATHETER_S
from opensuction.procedure.planning.protocol import PAPER
from opensuction.settings import identification_file
from opensuction.simulation import rig as rigs
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import Loop
from opensuction.simulation.rig import Rig
from opensuction.twin import preset
from tests.cli.test_files import protocol_text
from tests.settings.test_identification_file import identified

TAUGHT_MM = 85.0


def test_names_of_the_bench_give_the_settings_of_its_nominal_machine() -> None:
    rig = rigs.rig("bench", 1, nominal=True)
    known = rigs.uncalibrated(rig.profile)
    for name, kind in (("none", CompensationKind.NONE), ("gap-width", CompensationKind.GAP_WIDTH)):
        found = controller_settings(machine="bench", protocol="paper", compensation=name)
        expected = Configuration(
            setup.settings(rig.profile, PAPER, kind, known, False, rig.site),
            setup.branches(kind, known),
        )
        assert configuration.to_json(found) == configuration.to_json(expected)


def played(found: Configuration, rig: Rig) -> trace.Columns:
    """A cycle of the nominal twin under these settings."""
    loop = Loop(found.settings, found.heads_mm, rig.machine)
    parked_mm = found.settings.parked.head_mm
    plant = preset.park(rig.machine, rig.values, parked_mm, rig.seed, 2)
    start = trace.power_up(loop, plant, NEW_CATHETER_S)
    return trace.record(loop, start, START, 120.0)[1]


@pytest.mark.parametrize("approach", ["travel", "contact"])
def test_a_machine_like_the_one_that_was_named_completes_its_cycle(approach: str) -> None:
    rig = rigs.rig("clinical", 1, nominal=True)
    carina_mm = rig.site.carina_mm
    found = controller_settings(patient="adult-icu", approach=approach, taught_mm=carina_mm)
    columns = played(found, rig)
    assert columns["phase"][-1] == Phase.PARKED
    assert not columns["verdict.trips"].any()
    deepest_mm = columns["truth.tip_mm"].max()
    if approach == "travel":
        assert carina_mm - 16.0 < deepest_mm < carina_mm - 10.0
    else:
        assert Phase.BACKING_OFF in columns["phase"]


def test_a_parameter_file_brings_compensator_and_model(tmp_path: Path) -> None:
    model = PUBLISHED._replace(offset_mm=-6.5)
    file = tmp_path / "mine.toml"
    file.write_text(identification_file.to_toml(identified(model, "exact-inverse")), "utf-8")
    found = controller_settings(machine="bench", protocol="paper", compensation=str(file))
    assert found.settings.compensation.kind == CompensationKind.EXACT_INVERSE
    assert found.settings.compensation.model == model


REFUSED: dict[str, dict[str, Any]] = {
    "patient: a machine at a patient needs one": {"taught_mm": TAUGHT_MM},
    "protocol 'adult' is fitted to the patient: give taught_mm": {"patient": "adult-icu"},
    "patient 'adlt'": {"patient": "adlt", "taught_mm": TAUGHT_MM},
    "machine 'lathe'": {"machine": "lathe", "patient": "adult-icu", "taught_mm": TAUGHT_MM},
    "compensation 'magic'": {
        "patient": "adult-icu",
        "taught_mm": TAUGHT_MM,
        "compensation": "magic",
    },
    "approach 'sideways'": {
        "patient": "adult-icu",
        "taught_mm": TAUGHT_MM,
        "approach": "sideways",
    },
    "40 mm would do nothing": {"machine": "bench", "protocol": "paper", "taught_mm": 40.0},
    "protocol 'paper' is for the bench only": {
        "machine": "clinical",
        "patient": "adult-icu",
        "protocol": "paper",
    },
    "400 mm": {"patient": "adult-icu", "taught_mm": 400.0},
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_is_not_known_or_does_not_fit_is_refused_in_one_line(words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        controller_settings(**REFUSED[words])
    assert "\n" not in str(caught.value)


def test_a_protocol_file_too_is_held_against_the_taught_length(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(
        protocol_text(travel_mm=40.0, cap_mm=46.0, negative_pressure_budget_s=15.0), "utf-8"
    )
    named: dict[str, Any] = {"patient": "adult-icu", "protocol": str(file)}
    with pytest.raises(InputError, match="is held against the patient's depth: give taught_mm"):
        controller_settings(**named)
    with pytest.raises(InputError, match=r"taught length is 49\.9 mm - 4"):
        controller_settings(**named, taught_mm=49.9)
    assert controller_settings(**named, taught_mm=50.0).settings.limits.cap_mm == 46.0
