"""A campaign that is cut off goes on where it was."""

from pathlib import Path

import pytest

from opensuction.evidence.trial import campaign_store, fault_campaign
from opensuction.evidence.trial.fault_campaign import Case, Part
from opensuction.simulation.injection.invariant import Breach
from opensuction.twin.fault.fault import Fault

WHOLE = Part(machines=8, first_seed=900, compensation="preview", first=10, last=14)


def case(number: int) -> Case:
    breach = Breach("a bound", 1.25, 2.5, 0.5)
    return Case(
        drawn=fault_campaign.draw(number, WHOLE.machines),
        faults=(Fault.GEAR_LOST, Fault.PUMP_LOST)[: 1 + number % 2],
        noticed=number % 3 == 0,
        commands=(),
        physical=(breach,) if number % 2 else (),
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
