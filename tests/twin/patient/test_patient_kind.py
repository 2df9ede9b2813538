"""A patient's values fit together in one body, or are refused with the arithmetic."""

import pytest

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.twin.patient import patient_kind, patient_preset
from opensuction.twin.patient.patient_kind import PatientKind
from opensuction.twin.patient.patient_parameter import PRESETS


def changed(name: str, **values: float) -> PatientKind:
    kind = patient_kind.of_preset(name)
    table = dict(kind.table)
    for key, value in values.items():
        table[key] = table[key]._replace(value=value, spread=0.0)
    return PatientKind(table, kind.age)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_and_whatever_is_drawn_from_them_fit_together(name: str) -> None:
    kind = patient_kind.of_preset(name)
    patient_kind.check(kind)
    for seed in range(300):
        assert patient_kind.draw(kind, seed) == patient_preset.patient(name, seed)


@pytest.mark.parametrize(
    ("name", "values", "arithmetic"),
    [
        ("adult-icu", {"weight_kg": 3.5}, r"weight_kg 3\.5 kg .*\(adult: 30 to 200 kg\)"),
        ("neonate", {"tube_id_mm": 8.5}, r"tube_id_mm 8\.5 mm .*\(neonate: 2\.5 to 4\.5 mm\)"),
        ("neonate", {"carina_mm": 65.0}, r"65 mm .* 20 mm .* trachea of 85 mm; .* 50 mm"),
        ("child-10kg", {"carina_mm": 80.0}, r"trachea of 100 mm; .* 93 mm: .* at most 73 mm"),
        ("neonate", {"rise_s": 0.3}, r"rise_s 0\.3 s is too long for inspiration of 0\.49 s"),
        ("adult-ards", {"peep_cmh2o": 25.0, "tidal_ml_per_kg": 12.0}, r"= PEEP 25 \+ 3\d for 12"),
        ("adult-icu", {"peep_cmh2o": 0.1}, r"closing_margin_cmh2o 0\.2 cmH2O is more than"),
        ("adult-icu", {"residual_ml_per_kg": 18.0}, r"0\.95 x \(relaxed 22 - residual 18\) = 3\.8"),
        ("adult-icu", {"tidal_ml_per_kg": 3.0, "dead_space_ml_per_kg": 3.5}, "dead space of 3.5"),
        (
            "child-10kg",
            {"oxygen_ratio": 0.21, "tidal_ml_per_kg": 4.0},
            r"38 mmHg = 150 inspired - 863 x 6\.5 / 50",
        ),
        ("adult-icu", {"output_l_per_min_per_kg": 0.03}, r"0\.7 of the 4\.4 mL/min/kg"),
        ("neonate", {"lively": 0.5}, r"lively is 0\.5: 1 for a lively patient, 0 for a quiet one"),
        (
            "neonate",
            {"adherent_ratio": 0.9, "deep_ratio": 0.2},
            r"are up to 1\.10 of all secretions",
        ),
    ],
)
def test_what_does_not_fit_is_refused_with_the_arithmetic(
    name: str, values: dict[str, float], arithmetic: str
) -> None:
    with pytest.raises(InputError, match=arithmetic):
        patient_kind.check(changed(name, **values))


def test_a_draw_that_cannot_be_names_its_seed() -> None:
    kind = patient_kind.of_preset("neonate")
    table = dict(kind.table)
    table["carina_mm"] = table["carina_mm"]._replace(value=29.0, spread=2.0)
    refused = 0
    for seed in range(20):
        try:
            patient_kind.draw(PatientKind(table, AgeGroup.NEONATE), seed)
        except InputError as problem:
            assert str(problem).startswith(f"seed {seed} draws")
            refused += 1
    assert 0 < refused < 20
