"""Twin and controller of a machine are held against each other before anything runs."""

import numpy as np
import pytest

from opensuction.hysteresis import modified_dahl
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.settings import conduit_file
from opensuction.simulation import machine_kind
from opensuction.simulation import rig as rigs
from opensuction.simulation.machine_kind import MachineKind
from opensuction.twin import parameter, preset
from opensuction.twin.machine import catheter, suction_line, transmission
from opensuction.twin.parameter import SPREAD_LIMIT
from opensuction.twin.patient import patient_kind
from tests.settled import settled

CLINICAL = machine_kind.of_preset("clinical", AgeGroup.ADULT)
BENCH = machine_kind.of_preset("bench", None)


def twin(name: str, value: float) -> MachineKind:
    entry = CLINICAL.table[name]._replace(value=value, spread=0.0)
    return CLINICAL._replace(table={**CLINICAL.table, name: entry})


def controller(**values: float) -> MachineKind:
    return CLINICAL._replace(profile=CLINICAL.profile._replace(**values))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["bench", "clinical"])
def test_every_preset_agrees_with_its_controller(name: str) -> None:
    machine_kind.check(machine_kind.of_preset(name, None))


@pytest.mark.parametrize(
    ("kind", "arithmetic"),
    [
        (twin("supply_v", 20.0), r"24 V and twin\.supply_v 20 V"),
        (twin("no_load_mm_per_s", 40.0), r"does 39\.1 mm/s = 40\.0 mm/s .* 0\.53 V .* / 24 V"),
        (controller(head_limit_mm_per_s=80.0), r"1\.05 x 62\.0 = 65\.1 mm/s"),
        (controller(head_limit_mm_per_s=45.0), r"50 mm/s is above head_limit_mm_per_s 45 mm/s"),
        (
            controller(acceleration_mm_per_s2=500.0),
            r"5 N / 16\.4 kg less 103 mm/s\^2 of friction are 202",
        ),
        (controller(cam_open_rad=0.3), r"57 % of its stroke"),
        (controller(cam_rad_per_s=3.0), r"2\.69 rad/s = 3\.14 rad/s without load x \(1 - 3\.47 V"),
        (twin("cam_no_load_rad_per_s", 0.9), r"cam does 0\.77 rad/s"),
    ],
)
def test_a_controller_for_another_machine_is_refused_with_the_arithmetic(
    kind: MachineKind, arithmetic: str
) -> None:
    with pytest.raises(InputError, match=arithmetic):
        machine_kind.check(kind)


@pytest.mark.requirement("OS-R07")
@pytest.mark.parametrize(
    ("age", "open_ratio"), [(AgeGroup.ADULT, 1.0), (AgeGroup.CHILD, 0.0), (AgeGroup.NEONATE, 0.0)]
)
def test_the_relief_valve_alone_holds_what_the_age_allows(age: AgeGroup, open_ratio: float) -> None:
    """The stiffest valve that is drawn takes the strongest pump's whole flow below the limit.

    An adult's only while the catheter draws: a set point up to the limit is allowed there.
    """
    kind = machine_kind.of_preset("clinical", age)
    most = {name: row.value + SPREAD_LIMIT * row.spread for name, row in kind.table.items()}
    line = preset.machine(most, catheter=kind.catheter, conduit=kind.conduit).line
    wild = line._replace(pump_runs_away=True, regulator_ml_per_s_per_mmhg=0.0)
    state = suction_line.SuctionState(vacuum_mmhg=0.0, gas_ml_per_s=0.0, gas_ml=0.0)
    step = settled(suction_line.step)
    for _ in range(10_000):
        state = step(wild, state, False, 0.0, open_ratio, 0.0, 0.001)
    assert (state.vacuum_mmhg > line.relief_mmhg) == (open_ratio == 0.0)
    assert state.vacuum_mmhg < GUIDELINES[age].vacuum_mmhg


@pytest.mark.parametrize("route", catheter.ROUTES)
def test_the_controller_is_told_of_the_gap_of_its_conduit(route: str) -> None:
    """The nominal model must be about as wide as what is identified: the governor goes by it."""
    laid = catheter.lay(route, CLINICAL.catheter)
    kind = machine_kind.equipped(CLINICAL, CLINICAL.catheter, laid)
    person = patient_kind.of_preset("adult-icu")
    found = rigs.identify(rigs.rig_of(kind, person, 1, nominal=True)).fit.model
    told = kind.profile.transmission
    half_width = told.velocity_gain / told.decay_per_mm
    assert half_width == pytest.approx(found.velocity_gain / found.decay_per_mm, rel=0.15)


@pytest.mark.parametrize("name", conduit_file.TRANSMISSION_NAMES)
def test_a_controller_is_told_of_its_machines_transmission(name: str) -> None:
    """The nominal model leaves of the nominal machine about what identification leaves of ours."""
    kind = machine_kind.transmitting(BENCH, conduit_file.find(name))
    machine_kind.check(kind)
    conduit = preset.transmission_of(parameter.nominal(kind.table), kind.transmission)
    head = np.concatenate([np.linspace(0.0, 100.0, 5000), np.linspace(100.0, 0.0, 5000)])
    start = transmission.after_retract(conduit, 0.0)
    tip = transmission.simulate(conduit, start, head, 0.001)
    told = kind.profile.transmission
    model = modified_dahl.simulate(told, head, float(modified_dahl.saturation_mm(told)))
    assert np.sqrt(np.mean(np.square(tip - model))) < 1.2


def test_another_conduit_makes_every_gap_wider() -> None:
    for name in conduit_file.TRANSMISSION_NAMES:
        kind = machine_kind.transmitting(BENCH, conduit_file.find(name))
        looped = machine_kind.equipped(kind, kind.catheter, catheter.lay("looped", kind.catheter))
        ratio = catheter.gap_ratio(kind.catheter, looped.conduit)
        values = parameter.nominal(kind.table)
        one, other = (
            preset.machine(values, None, each.catheter, each.conduit, each.transmission)
            for each in (kind, looped)
        )
        assert other.transmission.widths_mm == pytest.approx(
            [ratio * width for width in one.transmission.widths_mm]
        )
        assert other.transmission.lag_ratio == pytest.approx(ratio * one.transmission.lag_ratio)
        was, now = kind.profile.transmission, looped.profile.transmission
        assert now.decay_per_mm == pytest.approx(was.decay_per_mm / ratio)


def test_a_seed_draws_the_transmission_with_the_machine() -> None:
    kind = machine_kind.transmitting(BENCH, conduit_file.find("preisach-25"))
    drawn = {rigs.rig_of(kind, None, seed).machine.transmission.widths_mm for seed in range(1, 6)}
    assert len(drawn) == 5
    assert rigs.rig_of(kind, None, 1).machine == rigs.rig_of(kind, None, 1).machine
