"""Machine files: complete, by name, and agreed between twin and controller."""

from pathlib import Path

import pytest

from opensuction.kernel.errors import InputError
from opensuction.settings import equipment_file
from opensuction.simulation import machine_kind
from opensuction.twin import parameter, transmission_parameter
from opensuction.twin.conduit import play_line
from opensuction.twin.machine import catheter

LEAST = 'preset = "clinical"\ncatheter = "12fr"\nconduit = "standard"\n'


def written(folder: Path, text: str) -> Path:
    file = folder / "m.toml"
    file.write_text(text)
    return file


def test_the_least_file_is_its_preset(tmp_path: Path) -> None:
    kind = equipment_file.load_machine(written(tmp_path, LEAST))
    assert kind == machine_kind.of_preset("clinical", None)


def test_a_file_changes_what_it_names_and_nothing_else(tmp_path: Path) -> None:
    text = LEAST.replace("12fr", "6fr").replace("standard", "short")
    text += "[twin]\npump_free_l_per_min = 15\n[controller]\ncam_rad_per_s = 0.8\n"
    kind = equipment_file.load_machine(written(tmp_path, text))
    assert kind.profile.cam_rad_per_s == 0.8
    assert kind.table["pump_free_l_per_min"].value == 15.0
    assert parameter.nominal(kind.table) == {
        **parameter.nominal(parameter.CLINICAL),
        "pump_free_l_per_min": 15.0,
    }
    assert kind.catheter == catheter.CATHETERS["6fr"]
    assert kind.conduit == catheter.lay("short", kind.catheter)
    start = machine_kind.of_preset("clinical", None).profile.transmission
    told = kind.profile.transmission
    assert told.decay_per_mm / start.decay_per_mm == pytest.approx(9.6 / 6.2832, rel=1e-4)


def test_catheter_and_conduit_may_be_sections_of_their_own(tmp_path: Path) -> None:
    text = """preset = "bench"
[catheter]
outer_mm = 3.0
bore_mm = 2.5
[conduit]
bore_mm = 4.5
length_mm = 1400
bend_rad = 8.0
"""
    kind = equipment_file.load_machine(written(tmp_path, text))
    assert kind.catheter == catheter.Catheter(3.0, 2.5)
    assert kind.conduit == catheter.Conduit(4.5, 1400.0, 8.0)
    assert catheter.gap_ratio(kind.catheter, kind.conduit) == pytest.approx(12.0 / 19.2)


def test_a_transmission_brings_its_parameters(tmp_path: Path) -> None:
    text = LEAST + 'transmission = "rubbing"\n[twin]\nrub_static_mm = 2.0\n'
    kind = equipment_file.load_machine(written(tmp_path, text))
    assert kind.transmission == play_line.RUBBING
    assert kind.table["rub_static_mm"].value == 2.0
    assert kind.table["rub_kinetic_mm"] == transmission_parameter.RUBBING["rub_kinetic_mm"]


def test_the_clearances_are_a_transmission_by_name(tmp_path: Path) -> None:
    kind = equipment_file.load_machine(written(tmp_path, LEAST + 'transmission = "plays"\n'))
    assert kind == equipment_file.load_machine(written(tmp_path, LEAST))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            LEAST + 'transmission = "rubing"\n',
            "unknown transmission 'rubing': did you mean 'rubbing'",
        ),
        (LEAST + "transmission = 3\n", "unknown transmission 3; known: plays, bouc-wen, rubbing"),
        (LEAST + "[transmission]\n", "unknown transmission a section; known: plays"),
        (LEAST + "[twin]\nrub_static_mm = 2.0\n", "unknown key twin.rub_static_mm"),
        (
            LEAST + 'transmission = "rubbing"\n[twin]\nrub_static_mm = 0\n',
            "twin.rub_static_mm is 0 mm; give a number from 0.05 to 10 mm",
        ),
        ("", "preset is missing; give one of bench, clinical"),
        ('preset = "clinical"\nconduit = "short"\n', "catheter is missing; give one of 6fr, 8fr"),
        ('preset = "clinical"\ncatheter = "6fr"\n', "conduit is missing; give one of standard"),
        (LEAST.replace("clinical", "clinicl"), "unknown preset 'clinicl': did you mean 'clinical'"),
        (LEAST.replace('"clinical"', "3"), "unknown preset 3; known: bench, clinical"),
        (LEAST.replace("12fr", "13fr"), "unknown catheter '13fr': did you mean "),
        (LEAST.replace("standard", "loped"), "unknown conduit 'loped': did you mean 'looped'"),
        (LEAST + "twni = 3\n", "unknown key twni: did you mean 'twin'"),
        (LEAST + "twin = 3\n", "twin is 3, not a section"),
        (LEAST + "controller = 3\n", "controller is 3, not a section"),
        (LEAST + "[twin]\nsuply_v = 24.0\n", "unknown key twin.suply_v: did you mean 'supply_v'"),
        (LEAST + "[twin]\nbend_rad = 9.0\n", "twin.bend_rad follows from the conduit"),
        (LEAST + "[twin]\ncarina_mm = 60.0\n", "twin.carina_mm is the patient's"),
        (LEAST + "[twin]\nsupply_v = 20\n", "controller.supply_v is 24 V and twin.supply_v 20 V"),
        (
            LEAST + "[controller]\ncam_deg_per_s = 15\n",
            "controller.cam_deg_per_s: did you mean 'cam_",
        ),
        (LEAST + "[controller]\nexcitation = 3\n", "unknown key controller.excitation"),
        (
            LEAST + "[controller]\ncam_rad_per_s = 15\n",
            "controller: cam_rad_per_s is 15 rad/s, above the limit of 10 rad/s",
        ),
        (LEAST + "[controller]\ncam_rad_per_s = nan\n", "cam_rad_per_s is nan, not a finite"),
        (
            LEAST.replace('catheter = "12fr"', "") + "[catheter]\nouter_mm = 4.0\n",
            "section catheter: bore_mm is missing; give a number in mm",
        ),
        (
            LEAST.replace('conduit = "standard"', "")
            + "[conduit]\nbore_mm = 4.0\nlength_mm = 1500\nbend_rad = 9.0\n",
            "a bore of 4 mm less 4 mm leaves 0 mm of clearance",
        ),
    ],
)
def test_anything_else_is_refused_in_one_line(text: str, words: str, tmp_path: Path) -> None:
    file = written(tmp_path, text)
    with pytest.raises(InputError) as refused:
        equipment_file.load_machine(file)
    assert str(refused.value).startswith(f"{file}: ")
    assert str(refused.value).count(str(file)) == 1
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
