"""A life that is shown: its course, its recordings and its page; watching changes nothing."""

import re
from pathlib import Path

import numpy as np
import pytest

from opensuction.evidence.lives import life, life_page, lives
from opensuction.evidence.lives.life_fault import ALL, RECORDER, SUPERVISOR, Kind, LifeFault
from opensuction.evidence.lives.life_record import Life, WatchedLife
from opensuction.evidence.lives.simulated_machine import NatureClock
from opensuction.host.host import NS_PER_S
from opensuction.kernel.vocabulary import Phase
from opensuction.recording.cycle_file.reader import RecordingReader
from opensuction.report import sheet
from opensuction.runtime import replay
from opensuction.runtime.supervisor import SupervisedProcess
from tests.report.page_data import payload

STANDSTILL_S = 3.0
FAULTS = (
    LifeFault(Kind.FREEZE, RECORDER, Phase.CHECKING, 0.05, 0.4),
    LifeFault(Kind.STANDSTILL, "", Phase.SUCTIONING, 0.05, STANDSTILL_S),
    LifeFault(Kind.KILL, ALL, None, 17.0, 0.0),
)
LIFE = Life(1, 3, FAULTS)


@pytest.mark.parametrize("kind", Kind)
def test_a_life_with_any_kind_of_fault_has_a_page(kind: Kind) -> None:
    fault = LifeFault(kind, RECORDER if kind in (Kind.KILL, Kind.FREEZE) else "", None, 4.0, 0.1)
    found = life.watch(Life(1, 3, (fault,)))
    assert found.result.violations == ()
    html = sheet.render(life_page.page(lives.to_played(found.result), found.result, found.course))
    assert str(kind) in html


@pytest.fixture(scope="module")
def watched() -> WatchedLife:
    return life.watch(LIFE)


def states(found: WatchedLife, process: str) -> list[str]:
    return [one.state for one in found.course.stretches if one.process == process]


def test_a_life_that_is_watched_is_the_same(watched: WatchedLife) -> None:
    assert watched.result == life.play(LIFE)


def test_the_course_shows_what_became_of_every_process(watched: WatchedLife) -> None:
    assert states(watched, "twin") == ["alive", "frozen", "alive"]
    recorder = states(watched, "recorder")
    assert recorder[:4] == ["starting", "alive", "frozen", "alive"]
    assert recorder[-3:] == ["starting", "alive", "dead"]
    stood = next(
        one for one in watched.course.stretches if (one.process, one.state) == ("twin", "frozen")
    )
    assert stood.to_s - stood.from_s == pytest.approx(STANDSTILL_S, abs=0.01)
    killed_s = next(one.at_s for one in watched.result.events if "kill-all" in one.what)
    dead = [one for one in watched.course.stretches if one.state == "dead"]
    found = {one.process for one in dead if one.from_s == pytest.approx(killed_s, abs=0.01)}
    assert found == {"control", "recorder", "supervisor"}
    ended_s = {one.at_s for one in watched.result.events if one.kind == "process"}
    assert {one.from_s for one in dead} <= ended_s


@pytest.mark.soak
def test_the_course_shows_a_short_freeze_as_short_as_it_is() -> None:
    """Whoever stands still has no step due meanwhile, and controller and twin tick on."""
    short = LifeFault(Kind.FREEZE, SUPERVISOR, Phase.CHECKING, 0.05, 0.005)
    found = life.watch(Life(1, 3, (short,)))
    (stood,) = [one for one in found.course.stretches if one.state == "frozen"]
    assert stood.process == "supervisor"
    assert stood.to_s - stood.from_s == pytest.approx(0.005)


def test_the_tip_is_where_the_phases_say_though_the_host_stood_still(watched: WatchedLife) -> None:
    """The twin makes up for a second of it at most: its time is behind from then on."""
    course = watched.course
    assert np.all(np.diff(course.time_s) > 0.0)
    begun = {one.what: one.at_s for one in watched.result.events if one.kind == "phase"}
    deep = course.time_s[course.tip_mm > 0.0]
    assert begun["phase inserting"] < deep[0] < begun["phase suctioning"] < deep[-1]
    stood_s = next(one.at_s for one in watched.result.events if "standstill" in one.what)
    still = (course.time_s > stood_s + 0.01) & (course.time_s < stood_s + STANDSTILL_S - 1.1)
    assert not np.any(still)


def test_people_are_told_of_a_standstill_when_it_is_over_and_not_before(
    watched: WatchedLife,
) -> None:
    stood_s = next(one.at_s for one in watched.result.events if "standstill" in one.what)
    told_s = [one.at_s for one in watched.result.events if one.what.endswith("watchdog-fired")]
    first_s = min(at_s for at_s in told_s if at_s > 1.0)
    # Nature goes on for the last second of it, which the twin makes up for.
    assert stood_s + STANDSTILL_S - 1.1 < first_s < stood_s + STANDSTILL_S + 0.1


def test_a_clock_of_nature_that_stands_still_is_behind_from_then_on() -> None:
    clock = NatureClock()
    clock.note(1.0, 5 * NS_PER_S)
    clock.note(1.0, 6 * NS_PER_S)
    clock.note(2.0, 9 * NS_PER_S)
    asked = (0.5, 1.0, 1.5, 2.5)
    assert [clock.at_ns(one) / NS_PER_S for one in asked] == [4.5, 5.0, 8.5, 9.5]


def test_the_recordings_are_those_of_its_recorders_and_replay(
    watched: WatchedLife, tmp_path: Path
) -> None:
    assert watched.recordings
    for name, content in watched.recordings.items():
        file = tmp_path / name
        file.write_bytes(content)
        reader = RecordingReader(file)
        assert replay.replay(reader).identical
        reader.close()


def test_the_page_has_all_of_a_life_and_needs_nothing_from_elsewhere(watched: WatchedLife) -> None:
    found = lives.to_played(watched.result)
    html = sheet.render(life_page.page(found, watched.result, watched.course))
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:|#)""", html)
    assert "not a medical device" in html
    for words in (found.id, found.trace, "Everything held", "seed 3", *found.faults):
        assert words in html
    for event in watched.result.events:
        assert f"{event.at_s:.3f}" in html
    plots = payload(html)
    tip, processes = plots["plot-1-1"], plots["plot-2-1"]
    assert tip["span"] == processes["span"]
    assert [shade[0] for shade in tip["shades"]][:4] == [
        "Parked",
        "Checking",
        "Taking up slack",
        "Inserting",
    ]
    assert [mark["name"] for mark in tip["marks"]] == ["freeze recorder", "standstill", "kill all"]
    lanes = {one["name"]: one["stretches"] for one in processes["lanes"]}
    assert list(lanes)[:4] == ["twin", "control", "recorder", "supervisor"]
    stood = lanes["faults"][1]
    assert stood[3] - stood[2] == pytest.approx(STANDSTILL_S)
    assert "watchdog-fired" in [one[0] for one in lanes["people are told"]]


def test_the_page_of_a_broken_life_says_what_broke_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SupervisedProcess, "look", lambda _: None)
    monkeypatch.setattr(life, "LONGEST_S", 20.0)  # it would never settle
    kill = LifeFault(Kind.KILL, "recorder", Phase.INSERTING, 0.05, 0.0)
    broken = life.watch(Life(1, 3, (kill,)))
    found = lives.to_played(broken.result)
    html = sheet.render(life_page.page(found, broken.result, broken.course))
    assert "Broken: rest" in html
    assert broken.result.violations[0].detail in html
