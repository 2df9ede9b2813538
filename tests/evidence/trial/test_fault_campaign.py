"""Random single and double faults: no command invariant breaks, no bound under one fault."""

import json
import os
from datetime import UTC, datetime
from pathlib import Path

import pytest

from docs.generator import campaign_page
from opensuction.evidence.trial import campaign_store, fault_campaign, fault_tally
from opensuction.evidence.trial.fault_campaign import FAULTS, PHASES, Case, Drawn, Part
from opensuction.evidence.trial.fault_tally import Tally
from opensuction.kernel.phase import Phase
from opensuction.settings.validation import to_mapping
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.invariant import Breach
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

SUITE = Part(machines=8, first_seed=900, compensation="preview", first=0, last=500)
"""A machine for each patient and approach."""
SOAK = Part(machines=64, first_seed=20_000, compensation="preview", first=0, last=100_000)


def assert_held(cases: list[Case]) -> Tally:
    """What no cycle may break."""
    assert [(case.drawn, case.commands) for case in cases if case.commands] == []
    alone = [case for case in cases if len(case.faults) == 1]
    assert [(case.drawn, case.physical) for case in alone if case.physical] == []
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
    assert found.single.cycles > 0.4 * cycles
    assert found.double.cycles > 0.16 * cycles


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
    assert {len(one.injections) for one in drawn[::2]} == {1}
    assert {len(one.injections) for one in drawn[1::2]} == {2}
    injections = [injection for one in drawn for injection in one.injections]
    assert {injection.fault for injection in injections} == set(FAULTS)
    assert {injection.at.phase for injection in injections} == set(PHASES)
    for injection in injections:
        ROWS[injection.fault].check_strength(injection.strength)


def test_a_number_draws_the_same_cycle_as_ever() -> None:
    """Published campaigns name cycles by number. A fault that is added renews every draw."""
    drawn = fault_campaign.draw(45, 8)
    assert drawn.machine == 1
    assert [(one.fault, one.at) for one in drawn.injections] == [
        (Fault.VACUUM_GLITCH, FaultInstant(Phase.INSERTING, 2.344)),
        (Fault.READING_LATE, FaultInstant(Phase.OPENING, 1.972)),
    ]
    strengths = [one.strength for one in drawn.injections]  # the second by its logarithm
    assert strengths == pytest.approx([-150.42941668070853, 0.047654055504119774], rel=1e-12)


def case(number: int, *faults: Fault, physical: bool = False, commands: bool = False) -> Case:
    breach = (Breach("a bound", 1.0, 2.0, 0.5),)
    at = FaultInstant(Phase.INSERTING, 0.0)
    drawn = Drawn(number, 0, tuple(Injection(fault, at, 0.0) for fault in faults))
    return Case(drawn, faults, False, breach if commands else (), breach if physical else ())


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
