"""A campaign that is cut off goes on where it was."""

import math
from pathlib import Path

import pytest

from opensuction.evidence.trial import campaign_store, fault_campaign
from opensuction.evidence.trial.fault_campaign import Case, Part
from opensuction.kernel.phase import Phase
from opensuction.oracle.harm import Harm
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.invariant import Breach
from opensuction.simulation.injection.run_judgement import LeftInside
from opensuction.twin.fault.fault import Fault

WHOLE = Part(machines=8, first_seed=900, compensation="preview", first=10, last=14)


def case(number: int) -> Case:
    breach, harm = Breach("a bound", 1.25, 2.5, 0.5), Harm("force", 0.4, 0.3, "N")
    stays = LeftInside("", "Draw it out.", math.nan, in_time=False)
    return Case(
        drawn=fault_campaign.draw(number, WHOLE.machines),
        injections=(Injection(Fault.GEAR_LOST, FaultInstant(Phase.SUCTIONING, 1.5), 0.0),),
        faults=(Fault.GEAR_LOST, Fault.PUMP_LOST)[: 1 + number % 2],
        told=number % 3 == 0,
        commands=(breach,) if number % 2 else (),
        breaches=(harm,) if number % 2 else (),
        left_inside=None if number % 2 else stays._replace(told_s=1.5),
    )


def test_a_part_comes_back_as_it_was(tmp_path: Path) -> None:
    cases = [case(number) for number in range(10, 14)]
    campaign_store.keep(tmp_path, WHOLE, cases)
    assert campaign_store.kept(tmp_path, WHOLE) == cases
    assert campaign_store.kept(tmp_path, WHOLE._replace(last=15)) is None


def test_cases_of_other_sources_are_other_cases(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    campaign_store.keep(tmp_path, WHOLE, [case(10)])
    monkeypatch.setattr(campaign_store, "sources_hash", lambda: "0123456789abcdef")
    assert campaign_store.kept(tmp_path, WHOLE) is None


def test_what_was_played_is_not_played_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for first in (10, 12):
        part = WHOLE._replace(first=first, last=first + 2)
        campaign_store.keep(tmp_path, part, [case(first), case(first + 1)])
    monkeypatch.setattr(fault_campaign, "played_part", None)
    found = campaign_store.spread(tmp_path, WHOLE, workers=1, size=2)
    assert found == [case(number) for number in range(10, 14)]
