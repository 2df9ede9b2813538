"""Random single and double faults: no command invariant breaks, no bound under one fault."""

import json
import os
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from docs.generator import campaign_page
from opensuction.evidence import healthy_cycle
from opensuction.evidence.trial import campaign_store, fault_campaign, fault_tally
from opensuction.evidence.trial.fault_campaign import FAULTS, Case, Drawn, DrawnFault, Part
from opensuction.evidence.trial.fault_tally import Tally
from opensuction.kernel.errors import InputError
from opensuction.oracle import exposure
from opensuction.oracle.harm import Harm
from opensuction.session.cycle import cycle_run
from opensuction.settings.validation import to_mapping
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.invariant import Breach
from opensuction.simulation.injection.run_judgement import LeftInside
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

SUITE = Part(machines=8, first_seed=900, compensation="preview", first=0, last=500)
"""A machine for each patient and approach."""
SOAK = Part(machines=64, first_seed=20_000, compensation="preview", first=0, last=100_000)


def assert_held(cases: list[Case]) -> Tally:
    """What no cycle may break."""
    assert [(case.drawn, case.commands) for case in cases if case.commands] == []
    alone = [case for case in cases if len(case.faults) == 1]
    assert [(case.drawn, case.injections, case.breaches) for case in alone if case.breaches] == []
    found = fault_tally.tally(cases)
    assert found.fault_free.broken == 0
    assert found.false_alarms == 0
    return found


@pytest.mark.parametrize(
    ("first", "last"), [(0, 200), pytest.param(200, 500, marks=pytest.mark.sweep)]
)
def test_no_invariant_breaks_under_faults_nor_a_bound_under_one(first: int, last: int) -> None:
    cycles = last - first
    found = assert_held(fault_campaign.played_part(SUITE._replace(first=first, last=last)))
    assert found.commands.cycles == cycles
    # Nothing is drawn in vain: a fault comes while the tip is inside, or about to be.
    assert found.single.cycles == cycles // 2
    assert found.double.cycles == cycles // 2
    assert found.fault_free.cycles == 0


@pytest.mark.soak
def test_no_invariant_breaks_in_a_hundred_thousand_cycles() -> None:
    folder = Path("runs") / "soak"
    folder.mkdir(parents=True, exist_ok=True)

    def tell(cycles: int) -> None:
        (folder / "fault-campaign.progress").write_text(f"{cycles} of {SOAK.last} cycles\n")

    cases = campaign_store.spread(folder, SOAK, os.cpu_count() or 1, tell=tell)
    result = {"in_silico": True, **SOAK._asdict(), **to_mapping(fault_tally.tally(cases))}
    (folder / "fault-campaign.json").write_text(json.dumps(result, indent=2) + "\n")
    page = campaign_page.markdown(result, datetime.now(UTC).date().isoformat())
    (folder / "faults.md").write_text(page)
    assert_held(cases)


def test_a_cycle_is_drawn_from_its_number_alone() -> None:
    drawn = [fault_campaign.draw(number, 8) for number in range(1000)]
    assert drawn[123] == fault_campaign.draw(123, 8)
    assert {len(one.faults) for one in drawn[::2]} == {1}
    assert {len(one.faults) for one in drawn[1::2]} == {2}
    faults = [fault for one in drawn for fault in one.faults]
    assert {one.fault for one in faults} == set(FAULTS)
    for one in faults:
        ROWS[one.fault].check_strength(one.strength)
    parts = np.histogram([one.share for one in faults], bins=5, range=(0.0, 1.0))[0]
    assert parts.min() > 0.8 * parts.mean()


def test_a_number_draws_the_same_cycle_as_ever() -> None:
    """Published campaigns name cycles by number. A fault that is added renews every draw."""
    drawn = fault_campaign.draw(29, 8)
    assert drawn.machine == 0
    assert [one.fault for one in drawn.faults] == [
        Fault.VENTILATOR_PRESSURE,
        Fault.CATHETER_KINKED,
    ]
    assert drawn.faults[0][1:] == pytest.approx((1.7585051734931767, 0.8953893937868997), rel=1e-12)
    assert drawn.faults[1][1:] == pytest.approx((0.6681629077938851, 0.4817222460405901), rel=1e-12)


def test_a_strength_of_a_wide_range_is_drawn_by_its_logarithm() -> None:
    (one,) = fault_campaign.draw(148, 8).faults
    assert one.fault == Fault.CONTACT_INTERMITTENT
    assert one.strength == pytest.approx(0.0013367503915681397, rel=1e-12)


def test_a_fault_comes_in_the_time_inside_or_a_second_before() -> None:
    """By the truth of a cycle without it, on every patient and by both approaches."""
    for prepared in fault_campaign.pool(8, 900, "preview"):
        healthy = healthy_cycle.play(prepared)
        columns = cycle_run.play(prepared)
        inside = exposure.find_inside(prepared.rig.machine, columns["truth.tip_mm"])
        ticks = np.flatnonzero(inside)
        for share in (0.0, 0.3, 0.5, 1.0):
            drawn = Drawn(0, 0, (DrawnFault(Fault.PUMP_LOST, 0.0, share),))
            (one,) = fault_campaign.place(drawn, healthy)
            tick = round(one.at.after_s / DT_S)
            assert ticks[0] - 1000 <= tick <= ticks[-1]
            assert inside[tick] or share == 0.0
            at = healthy_cycle.find_instant(healthy, "airway", share)
            assert columns["phase"][tick] == at.phase


def test_a_drawn_machine_that_cannot_do_its_protocol_makes_room_for_another() -> None:
    with pytest.raises(InputError, match="suction does not fit its budget"):
        fault_campaign.prepare(5, 47_024, "preview")
    rigs = [one.resolved.choice.rig for one in fault_campaign.pool(6, 47_024, "preview")]
    assert [rig.seed for rig in rigs] == [*range(47_024, 47_029), 47_024 + 5 + 6]
    assert rigs[5].patient == "child-10kg"


def case(number: int, *faults: Fault, physical: bool = False, commands: bool = False) -> Case:
    breach, harm = (Breach("a bound", 1.0, 2.0, 0.5),), (Harm("force", 0.4, 0.3, "N"),)
    drawn = Drawn(number, 0, tuple(DrawnFault(fault, 0.0, 0.5) for fault in faults))
    return Case(
        drawn=drawn,
        injections=(),
        faults=faults,
        told=False,
        commands=breach if commands else (),
        breaches=harm if physical else (),
        left_inside=None,
    )


def test_left_inside_is_counted_by_how_many_faults_came() -> None:
    stays = LeftInside("it is held fast", "Draw it out.", 0.5, in_time=True)
    alone = case(0, Fault.MOTOR_STALLED)._replace(left_inside=stays)
    late = alone._replace(left_inside=stays._replace(in_time=False))
    unneeded = alone._replace(left_inside=stays._replace(unavoidable=""))
    found = fault_tally.tally([alone, late, unneeded, case(1, Fault.PUMP_LOST)])
    assert found.left_inside["single"] == {"count": 3, "unavoidable": 2, "told": 2}
    none = {"count": 0, "unavoidable": 0, "told": 0}
    assert found.left_inside["none"] == found.left_inside["double"] == none


def test_breaches_are_counted_by_how_many_faults_came() -> None:
    pair = (Fault.PUMP_LOST, Fault.LINE_LEAK)
    found = fault_tally.tally(
        [case(0), case(1, Fault.PUMP_LOST), case(2, *pair, physical=True), case(3, *pair)]
    )
    assert (found.single.cycles, found.single.broken) == (1, 0)
    assert (found.double.cycles, found.double.broken) == (2, 1)
    assert found.commands.broken == 0
    (kind,) = found.breaches
    assert (kind.faults, kind.physical, kind.examples) == ("line-leak + pump-lost", True, (2,))


def test_a_breach_of_a_command_counts_whatever_came() -> None:
    found = fault_tally.tally([case(0, commands=True), case(1, Fault.PUMP_LOST)])
    assert (found.commands.cycles, found.commands.broken) == (2, 1)
    assert not found.breaches[0].physical


def test_the_bound_on_a_share_is_the_exact_one() -> None:
    """With none in n cycles: 1 - 0.05^(1/n)."""
    assert fault_tally.bound(100, 0).upper_percent == pytest.approx(100.0 * (1 - 0.05**0.01))
    assert fault_tally.bound(3, 3).upper_percent == 100.0
