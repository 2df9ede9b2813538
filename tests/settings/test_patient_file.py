"""Patient files: a preset, which gives the age, and what differs from it."""

from pathlib import Path

import pytest

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.settings import equipment_file
from opensuction.twin.patient import patient_kind


def written(folder: Path, text: str) -> Path:
    file = folder / "p.toml"
    file.write_text(text)
    return file


def test_the_least_file_is_its_preset(tmp_path: Path) -> None:
    kind = equipment_file.load_patient(written(tmp_path, 'preset = "neonate"\n'))
    assert kind == patient_kind.of_preset("neonate")
    assert kind.age == AgeGroup.NEONATE


def test_given_values_are_the_patient_s_for_every_seed(tmp_path: Path) -> None:
    text = 'preset = "adult-icu"\ncarina_mm = 72\nweight_kg = { value = 80, spread = 1.5 }\n'
    kind = equipment_file.load_patient(written(tmp_path, text))
    drawn = [patient_kind.draw(kind, seed) for seed in range(10)]
    assert {patient.carina_mm for patient in drawn} == {72.0}
    assert len({patient.weight_kg for patient in drawn}) == 10


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("carina_mm = 60\n", "preset is missing; give one of adult-icu"),
        ('preset = "adult"\n', "unknown preset 'adult': did you mean 'adult-icu'"),
        ('preset = "neonate"\ncarina = 12\n', "unknown key carina: did you mean 'carina_mm'"),
        ('preset = "neonate"\nshunt = 0.7\n', "shunt is 0.7; give a number from 0 to 0.5"),
        ('preset = "neonate"\nshunt = "low"\n', "shunt is 'low', not a number"),
        ('preset = "neonate"\ncarina_mm = 65\n', "make a trachea of 85 mm"),
        ('preset = "adult-icu"\nsecretion_depth_ratio = 1.2\n', "from 0.05 to 1"),
        (
            'preset = "adult-icu"\nlively = 0\ncough_per_h = 30\n',
            "cough_per_h is given, but lively is 0",
        ),
        ('preset = "adult-icu"\nlively = 1\ncough_per_h = 500\n', "a number from 0 to 120 1/h"),
        ('preset = "adult-icu"\nlively = 0.5\n', "lively is 0.5: 1 for a lively patient, 0 for"),
    ],
)
def test_anything_else_is_refused_in_one_line(text: str, words: str, tmp_path: Path) -> None:
    file = written(tmp_path, text)
    with pytest.raises(InputError) as refused:
        equipment_file.load_patient(file)
    assert str(refused.value).startswith(f"{file}: ")
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_lively_patient_does_what_the_file_says(tmp_path: Path) -> None:
    text = 'preset = "adult-icu"\nlively = 1\ncough_per_h = 30\nsedation_ratio = 0.5\n'
    kind = equipment_file.load_patient(written(tmp_path, text))
    drawn = patient_kind.draw(kind, 1).behaviour
    assert drawn.is_lively
    assert drawn.cough.spontaneous_per_s == pytest.approx(15.0 / 3600.0)
    # So is every drawn one that no file has still; what is exactly nominal lies still.
    assert patient_kind.draw(patient_kind.of_preset("adult-icu"), 1).behaviour.is_lively
    assert not patient_kind.draw(kind, 1, nominal=True).behaviour.is_lively
    still = equipment_file.load_patient(written(tmp_path, 'preset = "adult-icu"\nlively = 0\n'))
    assert not patient_kind.draw(still, 1).behaviour.is_lively
