import numpy as np
import pytest

from opensuction.twin import parameter, preset
from opensuction.twin.airway import airway as airway_model
from opensuction.twin.patient import patient_airway, patient_preset
from opensuction.twin.patient.patient_parameter import PRESETS

VALUES = parameter.nominal(parameter.CLINICAL)
ADULT = patient_preset.patient("adult-icu", 0, nominal=True)


@pytest.mark.parametrize("name", PRESETS)
def test_the_machine_touches_the_patient_s_carina(name: str) -> None:
    patient = patient_preset.patient(name, 3)
    airway = preset.machine(VALUES, patient).airway
    assert airway.carina_mm == patient.carina_mm
    assert airway.tip.carina_n_per_mm == patient.carina_n_per_mm


@pytest.mark.parametrize("name", PRESETS)
def test_every_patient_s_secretions_lie_within_reach(name: str) -> None:
    """All of them, however short the trachea: bins are 10 mm, a neonate's carina is at 12."""
    for seed in range(60):
        patient = patient_preset.patient(name, seed)
        bins = preset.secretions_ml(patient_airway.adapt(VALUES, patient))
        assert bins.sum() == pytest.approx(patient.secretion.volume_ml)
        starts = 10.0 * np.arange(bins.size)
        assert np.all(bins[starts >= patient.carina_mm] == 0.0)


def test_uptake_falls_with_viscosity() -> None:
    thick = ADULT._replace(secretion=ADULT.secretion._replace(viscosity_pa_s=1.0))
    thin = ADULT._replace(secretion=ADULT.secretion._replace(viscosity_pa_s=0.25))
    slow = preset.machine(VALUES, thick).airway.uptake_ml_per_s_per_mmhg
    fast = preset.machine(VALUES, thin).airway.uptake_ml_per_s_per_mmhg
    assert slow == VALUES["uptake_ml_per_s_per_mmhg"]  # given for 1 Pa s
    assert fast == pytest.approx(4.0 * slow)


@pytest.mark.parametrize("name", PRESETS)
def test_the_tip_closes_its_switch_before_it_buckles(name: str) -> None:
    """Else the carina could not be found by contact; and not long after, so that it is spared."""
    patient = patient_preset.patient(name, 0, nominal=True)
    buckling_n = preset.machine(VALUES, patient).airway.tip.buckling_n
    assert 1.2 * VALUES["switch_n"] < buckling_n <= 0.15


def test_a_longer_free_tip_buckles_sooner() -> None:
    near = patient_airway.adapt(VALUES, ADULT._replace(carina_mm=65.0))
    far = patient_airway.adapt(VALUES, ADULT._replace(carina_mm=72.0))
    longer = (72.0 + 80.0 / 3.0) / (65.0 + 80.0 / 3.0)
    assert near["buckling_n"] / far["buckling_n"] == pytest.approx(longer * longer)


@pytest.mark.requirement("OS-R06")
@pytest.mark.parametrize("name", PRESETS)
def test_a_tip_searched_with_to_the_end_spares_the_carina(name: str) -> None:
    """The tip as hard as the free length lets it be: 10 mm beyond the carina, which are the window
    and what a hand teaches too deep, without a switch to stop it."""
    for seed in range(60):
        patient = patient_preset.patient(name, seed)
        values = parameter.draw(parameter.CLINICAL, seed)
        pressing = preset.machine(values, patient).airway.tip
        assert pressing.buckling_n > 1.1 * values["switch_n"]
        assert airway_model.touch(pressing, 0.0, 10.0).force_n < 0.3


def test_a_patient_replaces_just_what_is_said_to_be_replaced() -> None:
    """A machine file may set everything else, and it must have an effect."""
    person = patient_preset.patient("adult-icu", 0, nominal=True)
    for name, value in VALUES.items():
        changed = {**VALUES, name: 1.01 * value if value != 0.0 else 0.001}
        same = patient_airway.adapt(changed, person) == patient_airway.adapt(VALUES, person)
        assert same is (name in patient_airway.REPLACED)
