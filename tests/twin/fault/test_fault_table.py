"""The table of faults: whole, within its own ranges, and numbered for good."""

import pytest

from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import NO_MONITOR, Readings
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.fault.fault import BY_NAME, Fault, FaultSite
from opensuction.twin.fault.fault_row import (
    FaultOnset,
    FaultRow,
    LinkEffect,
    MachineEffect,
    PatientEffect,
    ReadingEffect,
)
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.parameter import BENCH, nominal

MACHINE = preset.machine(nominal(BENCH))._replace(mouth_mm=-90.0)
READINGS = Readings(
    40.0, True, 40.0, True, 0.3, True, 100.0, True, False, True, True, 0.02, NO_MONITOR
)


def test_every_fault_has_one_row() -> None:
    assert set(ROWS) == set(Fault)
    assert {fault for fault, row in ROWS.items() if row.fault == fault} == set(Fault)
    assert {fault.title: fault for fault in Fault} == BY_NAME


def test_what_is_set_up_wrongly_is_there_from_the_start() -> None:
    assert {row.fault.site for row in ROWS.values() if row.is_setup} == {FaultSite.SETTING}
    assert {row.is_setup for row in ROWS.values() if row.fault.site == FaultSite.SETTING} == {True}
    assert {row.fault for row in ROWS.values() if row.is_planned} == {
        Fault.WRONG_PRESET,
        Fault.CATHETER_TOO_WIDE,
        Fault.TAUGHT_TOO_DEEP,
    }


@pytest.mark.parametrize("row", ROWS.values(), ids=lambda row: row.fault.title)
def test_a_default_strength_is_one_that_can_be_chosen(row: FaultRow) -> None:
    name, known = row.fault.title, row.strength
    row.check_strength(row.default_strength)
    if known is None:
        with pytest.raises(InputError, match="has no strength"):
            row.check_strength(0.5)
        return
    assert known.least < known.most
    for beyond in (known.least - 0.001, known.most + 0.001, float("nan")):
        with pytest.raises(InputError, match=f"'{name}' has no strength"):
            row.check_strength(beyond)


@pytest.mark.parametrize("row", ROWS.values(), ids=lambda row: row.fault.title)
def test_a_fault_changes_what_its_effect_is_on_and_nothing_else(row: FaultRow) -> None:
    strength = row.default_strength
    if isinstance(row.effect, MachineEffect | PatientEffect):
        broken = row.change_machine(MACHINE, strength)
        assert str(broken) != str(MACHINE)
        changed_patient = str(broken.patient) != str(MACHINE.patient)
        both = row.fault in (Fault.COUGH, Fault.DECANNULATION)
        assert changed_patient == (isinstance(row.effect, PatientEffect) or both)
    else:
        with pytest.raises(TypeError, match=row.fault.title):
            row.change_machine(MACHINE, strength)
    healthy, onset = link.healthy(seed=1), FaultOnset(strength, 5, 0.001)
    if isinstance(row.effect, ReadingEffect):
        assert row.change_reading(onset, READINGS, 1).channel == row.effect.channel
    else:
        with pytest.raises(TypeError, match=row.fault.title):
            row.change_reading(onset, READINGS, 1)
    if isinstance(row.effect, LinkEffect):
        assert row.change_link(healthy, onset) != healthy
    else:
        with pytest.raises(TypeError, match=row.fault.title):
            row.change_link(healthy, onset)
    assert row.is_linked == isinstance(row.effect, ReadingEffect | LinkEffect)


def test_a_strength_out_of_range_changes_no_machine() -> None:
    with pytest.raises(InputError, match="'line-leak' has no strength 0"):
        ROWS[Fault.LINE_LEAK].change_machine(MACHINE, 0.0)


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
        "encoder-glitch": 150,
        "current-glitch": 160,
        "cam-glitch": 170,
        "clamp-slipping": 180,
        "power-returning": 190,
        "monitor-frozen": 200,
    }
    assert {fault.title: int(fault) for fault in ROWS if fault.title in stored} == stored
