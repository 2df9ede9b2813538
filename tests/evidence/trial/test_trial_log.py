"""A trial that is cut off goes on where it was; another one is refused."""

import math
from pathlib import Path

import pytest

from opensuction.evidence.trial import trial
from opensuction.evidence.trial.trial import PlayedPart
from opensuction.kernel.errors import InputError
from opensuction.result.trial_result import Trial
from opensuction.twin.fault.fault import Fault
from tests.evidence.trial.example import BREACH, HARM, STAYS, case

HEADING = trial.make_heading(Trial(), 8)
BROKEN = case(2, Fault.GEAR_LOST, Fault.PUMP_LOST)._replace(
    commands=(BREACH._replace(worst=math.inf),),
    breaches=(HARM,),
    left_inside=STAYS._replace(told_s=0.5),
    true_alarms=("SPO2_LOW",),
    told=True,
)
PARTS = [
    PlayedPart(0, (case(1), case(9)), ("neonate, travel, seed 7: it cannot",)),
    PlayedPart(1, (BROKEN,), ()),
]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder that keeps a trial with two parts."""
    trial.begin(tmp_path, HEADING)
    for part in PARTS:
        trial.keep(tmp_path, part)
    return tmp_path


def test_parts_come_back_as_they_were(folder: Path) -> None:
    assert trial.read(folder).heading == HEADING
    assert trial.go_on(folder, HEADING) == {0: PARTS[0], 1: PARTS[1]}


def test_a_line_that_was_cut_off_is_as_if_it_were_not(folder: Path) -> None:
    file = folder / trial.NAME
    whole = file.read_bytes()
    file.write_bytes(whole[:-20])
    assert trial.go_on(folder, HEADING) == {0: PARTS[0]}
    trial.keep(folder, PARTS[1])
    assert file.read_bytes() == whole


def test_what_is_told_by_nobody_comes_back_too(folder: Path) -> None:
    part = PlayedPart(2, (BROKEN._replace(left_inside=STAYS._replace(told_s=math.nan)),), ())
    trial.keep(folder, part)
    found = trial.read(folder).parts[2].cases[0].left_inside
    assert found is not None
    assert math.isnan(found.told_s)


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        (HEADING._replace(cycles=9), "--cycles 8, not 9"),
        (HEADING._replace(trial=Trial(seed=2)), "--seed 1, not 2"),
        (HEADING._replace(trial=Trial(faults="double")), "--faults single, not double"),
        (HEADING._replace(trial=Trial(cohort="neonate")), "--cohort presets, not neonate"),
        (HEADING._replace(sources="0123456789abcdef"), "other sources"),
    ],
)
def test_another_trial_is_refused_and_nothing_is_lost(
    wanted: trial.Heading, words: str, folder: Path
) -> None:
    before = (folder / trial.NAME).read_bytes()
    with pytest.raises(InputError, match=words) as refused:
        trial.go_on(folder, wanted)
    assert "\n" not in str(refused.value)
    assert (folder / trial.NAME).read_bytes() == before


def test_a_change_of_what_judges_is_a_change_of_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = tmp_path / "oracle" / "bound.py"
    source.parent.mkdir()
    monkeypatch.setattr(trial, "PACKAGE", tmp_path)
    source.write_text("FORCE_N = 0.3\n")
    before = trial.hash_sources()
    assert trial.hash_sources() == before
    source.write_text("FORCE_N = 0.4\n")
    assert trial.hash_sources() != before


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "holds no trial"),
        ("", "has not begun"),
        ("nonsense\n", "line 1"),
        ('{"version": 1}\n', "line 1"),
    ],
)
def test_what_is_no_trial_is_refused_in_one_line(
    text: str | None, words: str, tmp_path: Path
) -> None:
    if text is not None:
        (tmp_path / trial.NAME).write_text(text)
    with pytest.raises(InputError, match=words) as refused:
        trial.read(tmp_path)
    assert "\n" not in str(refused.value)


def test_a_damaged_line_is_named(folder: Path) -> None:
    file = folder / trial.NAME
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(lines[0] + lines[1][:-30] + b"\n" + lines[2])
    with pytest.raises(InputError, match="line 2"):
        trial.read(folder)
