"""Recordings of simulated runs: they hold what happened, and replay gives every bit of it again."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from opensuction import __version__
from opensuction.controller.real_time_call import OUTPUT_COLUMNS
from opensuction.kernel import arithmetic_fingerprint
from opensuction.kernel.vocabulary import Phase
from opensuction.recording.cycle_file.reader import RecordingReader, Rows, TimedEvent
from opensuction.runtime.replay import Replay, replay
from opensuction.session.choice import CycleChoice, DayChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.day import day_run
from opensuction.session.recorded.cycle_recording import TWIN_EVERY
from opensuction.simulation.injection.injection import InjectedRun
from tests.session.recorded import played
from tests.session.recorded.played import Contents, Played

BENCH = RigChoice(machine="bench", seed=3)
COMPENSATIONS = (
    *("none", "direct-inverse", "exact-inverse", "gap-width", "lookup-table"),
    *("prandtl-ishlinskii", "preview"),
)
CHOICES = {
    **{name: CycleChoice(rig=BENCH, compensation=name) for name in COMPENSATIONS},
    "adult": CycleChoice(),
    "adult-contact": CycleChoice(approach="contact"),
    "child": CycleChoice(rig=RigChoice(patient="child-10kg", seed=2)),
    "neonate": CycleChoice(rig=RigChoice(patient="neonate", seed=4)),
    "no-oxygen": CycleChoice(preoxygenation="skipped"),
    "sensor": CycleChoice(faults=("encoder-drifting@inserting+2",)),
    "sensor-gone": CycleChoice(faults=("carriage-sensor-invalid@withdrawing+1",)),
    "link": CycleChoice(approach="contact", faults=("message-lost@inserting+3",)),
    "late": CycleChoice(faults=("tick-late@suctioning+0.2",)),
    "controller": CycleChoice(faults=("controller-stopped@inserting+4",)),
    "power": CycleChoice(
        rig=RigChoice(patient="neonate"), faults=("power-returning@withdrawing+1",)
    ),
    "no-controller": CycleChoice(faults=("power-lost-without-reserve@inserting+2",)),
    "machine": CycleChoice(faults=("catheter-jammed@withdrawing+1",)),
    "two": CycleChoice(faults=("reading-late@inserting+1", "line-leak@suctioning+0.1")),
    "old-catheter": CycleChoice(faults=("catheter-expired",)),
    "cough": CycleChoice(faults=("cough@inserting+5",)),
}


SHARE = ("none", "lookup-table", "adult-contact", "neonate", "link", "controller")
SWEPT = ("sensor-gone", "power", "no-controller", "two")
"""Tried by `.ci/run`, too; the rest, more of the same kinds, is for the long runs."""
WHOLE_S = {"adult": 90.0}
"""Of what is recorded as long as a person gets it, as the commands' own tests do."""


def _case(name: str) -> object:
    if name in SHARE:
        return name
    return pytest.param(name, marks=pytest.mark.sweep if name in SWEPT else pytest.mark.soak)


class _Kept(RecordingReader):
    """A recording whose content stays: it is unpacked once, for its replay and for the tests."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.read: list[Rows | TimedEvent] = []

    def contents(self) -> Iterator[Rows | TimedEvent]:
        for one in super().contents():
            self.read.append(one)
            yield one


class _Replayed(NamedTuple):
    """A run, what is in its recording, and what comes of that."""

    ran: InjectedRun
    contents: Contents
    replay: Replay


def _replayed(run: Played) -> _Replayed:
    reader = _Kept(run.path)
    found = replay(reader)
    return _Replayed(run.ran, played.gather(reader, reader.read), found)


def _play(name: str, tmp_path_factory: pytest.TempPathFactory) -> Played:
    path = tmp_path_factory.mktemp(name) / "a.mcap"
    return played.play(path, CHOICES[name], WHOLE_S.get(name, played.AFTERMATH_S))


@pytest.fixture(scope="module")
def restarted(tmp_path_factory: pytest.TempPathFactory) -> Played:
    return _play("controller", tmp_path_factory)


@pytest.fixture(scope="module")
def after_restart(restarted: Played) -> _Replayed:
    return _replayed(restarted)


@pytest.fixture(scope="module", params=[_case(name) for name in CHOICES])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> _Replayed:
    name: str = request.param
    if name == "controller":
        found: _Replayed = request.getfixturevalue("after_restart")
        return found
    return _replayed(_play(name, tmp_path_factory))


def test_replay_gives_every_output_and_state_again(run: _Replayed) -> None:
    found = run.replay
    spans = [span for span in run.ran.spans if span.runs]
    assert found.first is None
    assert found.identical
    assert found.ticks == sum(span.ticks for span in spans)
    assert found.starts == sum(span.state is not None for span in run.ran.spans)
    assert found.gaps == 0


def test_outputs_are_those_of_the_run_in_every_bit(run: _Replayed) -> None:
    contents = run.contents
    ticks = np.concatenate([np.arange(span.first, span.end) for span in run.ran.spans if span.runs])
    for name in OUTPUT_COLUMNS:
        if name in run.ran.sent:
            recorded = contents.column("/tick", f"outputs.{name}")
            assert np.array_equal(recorded, run.ran.sent[name][ticks], equal_nan=True), name
    truth = contents.column("/twin", "truth.tip_mm")
    assert np.array_equal(truth, run.ran.columns["truth.tip_mm"][::TWIN_EVERY])


def test_events_say_what_happened_and_when(after_restart: _Replayed) -> None:
    told = after_restart.contents.told
    found = [(one.event.kind, one.event.name) for one in told]
    assert ("request", "start") in found
    assert ("phase", "inserting") in found
    fault = next(one for one in told if one.event.kind == "fault")
    at_s = after_restart.ran.faults[0].at_s
    assert fault.event.name == "controller-stopped"
    assert fault.time_ns - played.BEGAN_NS == round(at_s * 1e9)
    assert [name for kind, name in found if kind == "start"] == ["begun", "restarted"]
    assert [name for kind, name in found if kind == "gap"] == ["controller-stopped"]
    raised = [one.event for one in told if one.event.kind == "told"]
    assert ("watchdog-fired", "drives") in [(one.name, one.who) for one in raised]
    times = [one.time_ns for one in told]
    assert times == sorted(times)


def test_phases_are_told_as_they_were(after_restart: _Replayed) -> None:
    phase = after_restart.ran.columns["phase"]
    names = [Phase(int(phase[0]))]
    names += [Phase(int(phase[at + 1])) for at in np.flatnonzero(np.diff(phase))]
    told = [one.event for one in after_restart.contents.told if one.event.kind == "phase"]
    assert [one.name for one in told] == [one.name.lower().replace("_", "-") for one in names]


def test_no_row_is_there_of_ticks_without_a_controller(after_restart: _Replayed) -> None:
    stopped = next(span for span in after_restart.ran.spans if not span.runs)
    ticks = after_restart.contents.column("/tick", "inputs.tick")
    assert stopped.ticks > 0
    assert not ((ticks >= stopped.tick) & (ticks < stopped.tick + stopped.ticks)).any()


def test_the_heading_names_what_replay_and_people_need(restarted: Played) -> None:
    reader = RecordingReader(restarted.path)
    reader.close()
    heading = reader.heading
    assert heading.software_version == __version__
    assert heading.fingerprint == arithmetic_fingerprint.fingerprint()
    assert heading.about["patient"] == "adult-icu"
    assert heading.about["seed"] == "1"
    assert heading.about["faults"] == "controller-stopped@inserting+4"
    assert "In-silico" in heading.about["notice"]
    assert heading.began_utc == "2026-11-18T11:06:40+00:00"


@pytest.mark.parametrize(
    "faults", [(), pytest.param(("vacuum-sensor-offset@3605",), marks=pytest.mark.sweep)]
)
def test_the_last_cycle_of_a_day_is_replayed_too(tmp_path: Path, faults: tuple[str, ...]) -> None:
    choice = CycleChoice(approach="contact", faults=faults)
    asked = DayChoice(repeat=2, every_min=60.0, self_calibrates=not faults)
    prepared = cycle_run.prepare(resolution.resolve(choice))
    day = day_run.play(prepared, asked, lambda *_: None)
    last = _replayed(played.write(tmp_path / "a.mcap", day.last, day.ran))
    assert last.replay.identical
    assert last.replay.ticks == last.ran.columns["time_s"].size
    ticks = last.contents.column("/tick", "inputs.tick")
    assert ticks[0] == day.ran.spans[0].tick > 3_000_000
