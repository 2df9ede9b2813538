"""The table of faults: whole, within its own ranges, and numbered for good."""

import pytest

from opensuction.kernel.errors import InputError
from opensuction.twin import preset
from opensuction.twin.fault import fault_effect, fault_table, link, reading_fault
from opensuction.twin.fault.fault import Fault, Means, Part
from opensuction.twin.fault.fault_table import KINDS
from opensuction.twin.parameter import BENCH, nominal

MACHINE = preset.machine(nominal(BENCH))
AWAITED = {fault for fault in Fault if 120 <= fault < 140}
"""Faults of the patient."""


def test_every_fault_has_a_row() -> None:
    assert set(Fault) - AWAITED <= set(KINDS)


def test_what_a_fault_does_is_written_once_for_each_means() -> None:
    def of(means: Means) -> set[Fault]:
        return {fault for fault, kind in KINDS.items() if kind.means == means}

    assert set(fault_effect.EFFECTS) == of(Means.MACHINE)
    assert set(reading_fault.KINDS) == of(Means.READING)
    healthy = link.healthy(seed=1)
    for fault in of(Means.LINK):
        strength = fault_table.default_strength(fault)
        assert link.with_fault(healthy, fault, strength, 5, 0.001) != healthy
    assert of(Means.SETTING) == {
        fault for fault, kind in KINDS.items() if kind.part == Part.SETTING
    }


@pytest.mark.parametrize("fault", KINDS, ids=lambda fault: fault.title)
def test_a_default_strength_is_one_that_can_be_chosen(fault: Fault) -> None:
    known = KINDS[fault].strength
    fault_effect.check_strength(fault, fault_table.default_strength(fault))
    if known is None:
        with pytest.raises(InputError, match="has no strength"):
            fault_effect.check_strength(fault, 0.5)
        return
    assert known.least < known.most
    for beyond in (known.least - 0.001, known.most + 0.001, float("nan")):
        with pytest.raises(InputError, match=f"'{fault.title}' has no strength"):
            fault_effect.check_strength(fault, beyond)


@pytest.mark.parametrize("fault", fault_effect.EFFECTS, ids=lambda fault: fault.title)
def test_a_fault_changes_the_machine(fault: Fault) -> None:
    strength = fault_table.default_strength(fault)
    assert str(fault_effect.faulty(MACHINE, fault, strength)) != str(MACHINE)


def test_a_fault_between_controller_and_machine_is_none_of_the_machine() -> None:
    with pytest.raises(KeyError):
        fault_effect.faulty(MACHINE, Fault.ENCODER_FROZEN, 0.0)


def test_numbers_stay_as_they_were_stored() -> None:
    """One of each part: results name faults by number."""
    stored = {
        "switch-stuck-open": 1,
        "carina-missed": 10,
        "catheter-kinked": 20,
        "motor-stalled": 30,
        "encoder-frozen": 40,
        "valve-stuck-open": 50,
        "cam-encoder-frozen": 60,
        "pump-runaway": 70,
        "vacuum-sensor-frozen": 80,
        "power-lost": 90,
        "controller-stopped": 100,
        "message-late": 110,
        "wrong-preset": 140,
    }
    assert {fault.title: int(fault) for fault in KINDS if fault.title in stored} == stored
