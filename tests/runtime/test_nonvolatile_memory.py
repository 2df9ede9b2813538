"""Passes, rest, lock-out and the catheter's age outlive a computer that loses its power."""

import json
import os
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from opensuction.controller import controller
from opensuction.controller.record import State
from opensuction.host.host import NS_PER_S, Host, Work, Worker, finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.interlocks import LIFE_S
from opensuction.procedure.cycle.schedule import PassRule
from opensuction.runtime import nonvolatile_memory
from opensuction.runtime.controller_memory import Before
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.nonvolatile_memory import WRITES_S, NonvolatileMemory
from opensuction.session.choice import CycleChoice
from opensuction.session.cycle import cycle_run, resolution
from tests.machine.canopen.stepped_bus import SteppedClock, stepped_host

RULE = PassRule(most_passes=3, rest_s=180.0, asks_for_oxygen=False)
UPKEEP = "state.core.upkeep."
WROTE_NS = 1_750_000_000 * NS_PER_S
HOUR_S = 3600.0


class WallClock(SteppedClock):
    """The wall clock stands still."""

    def wall_ns(self) -> int:
        return WROTE_NS


class AtOnce:
    """A worker that does its work as it is woken."""

    def __init__(self, work: Work) -> None:
        self._work, self.has_ended = work, False

    def wake(self) -> None:
        next(self._work)


def host_of(clock: SteppedClock) -> Host:
    return stepped_host(clock)._replace(begin_worker=AtOnce)


@pytest.fixture
def host() -> Host:
    return host_of(WallClock())


def row(phase: Phase = Phase.PARKED, at_s: float = 1.0, **upkeep: float) -> Array:
    """A row of a controller. upkeep: its interlocks; a blank in a name for the dot in it."""
    found = dict.fromkeys(ROW_COLUMNS, 0.0)
    found["loop.time_s"] = at_s
    found["state.core.procedure.phase"] = float(phase)
    for name, value in upkeep.items():
        column = f"{UPKEEP}{name.replace('__', '.')}"
        assert column in found
        found[column] = value
    return np.array(list(found.values()))


USED = row(
    episode__passes=2.0, episode__rest_left_s=120.0, lock__resets=1.0, catheter_age_s=5.0 * HOUR_S
)


def recall(path: Path, off_s: float, on_s: float = HOUR_S) -> Before:
    found = nonvolatile_memory.recall(path, WROTE_NS + round(off_s * NS_PER_S), on_s)
    assert found is not None
    return found


def begun(before: Before) -> State:
    """Controller that begins with it, at home."""
    settings = cycle_run.prepare(resolution.resolve(CycleChoice())).loop.controller
    return controller.restart(
        settings, settings.limits.park_head_mm, before.kept, before.off_s, before.phase
    )


@pytest.mark.parametrize(
    ("off_s", "on_s", "rest_left_s"),
    [(30.0, 3600.0, 90.0), (3600.0, 20.0, 100.0), (500.0, 500.0, 0.0)],
)
def test_a_rest_is_over_by_both_clocks_and_a_catheter_ages_by_the_wall_clock(
    tmp_path: Path, host: Host, off_s: float, on_s: float, rest_left_s: float
) -> None:
    path = tmp_path / "machine.json"
    NonvolatileMemory(path, host).take(USED, RULE)
    kept = begun(recall(path, off_s, on_s)).core.upkeep
    assert kept.episode.rest_left_s == pytest.approx(rest_left_s)
    assert kept.episode.passes == 2
    assert kept.lock.resets == 1
    assert kept.catheter_age_s == pytest.approx(5.0 * HOUR_S + off_s)


def test_a_controller_that_died_some_time_ago_has_left_a_catheter_that_has_aged_since(
    tmp_path: Path,
) -> None:
    clock = WallClock()
    clock.now_ns = 7 * NS_PER_S
    NonvolatileMemory(path := tmp_path / "machine.json", host_of(clock)).take(USED, RULE)
    assert recall(path, 0.0).kept.catheter_age_s == pytest.approx(5.0 * HOUR_S + 6.0, abs=1e-6)


def test_where_the_wall_clock_was_set_back_the_catheter_counts_as_over_its_life(
    tmp_path: Path, host: Host
) -> None:
    path = tmp_path / "machine.json"
    NonvolatileMemory(path, host).take(USED, RULE)
    before = recall(path, -10.0)
    kept = begun(before).core.upkeep
    assert kept.catheter_age_s >= LIFE_S
    assert kept.episode.rest_left_s == pytest.approx(120.0)
    assert "unknown age" in nonvolatile_memory.describe(before)


@pytest.mark.parametrize("phase", [Phase.CHECKING, Phase.PRELOADING])
def test_a_pass_that_is_about_to_begin_counts_as_made(
    tmp_path: Path, host: Host, phase: Phase
) -> None:
    """Or the power goes within the 20 ms that the recorder takes to see that the head moves."""
    path = tmp_path / "machine.json"
    NonvolatileMemory(path, host).take(row(phase, episode__passes=1.0), RULE)
    before = recall(path, 0.0)
    assert before.kept.episode.passes == 2
    assert before.kept.episode.rest_left_s == RULE.rest_s
    assert begun(before).core.procedure.phase == Phase.HALTED


@pytest.mark.parametrize(
    ("then", "writes"),
    [
        (row(episode__rest_left_s=7.0, oxygen__left_s=3.0, refusal=4.0), False),
        (row(Phase.HALTED), False),
        (row(Phase.CHECKING), True),
        (row(episode__passes=1.0), True),
        (row(episode__exceeded=1.0), True),
        (row(lock__resets=1.0), True),
        (row(lock__locked=1.0), True),
        (row(catheter_age_s=-1.0), True),
    ],
)
def test_it_is_written_where_something_else_than_time_changes_it(
    tmp_path: Path, host: Host, then: Array, writes: bool
) -> None:
    memory = NonvolatileMemory(path := tmp_path / "machine.json", host)
    memory.take(row(), RULE)
    path.unlink()
    memory.take(then, RULE)
    assert path.exists() == writes


def test_it_is_written_every_minute(tmp_path: Path) -> None:
    clock = WallClock()
    memory = NonvolatileMemory(path := tmp_path / "machine.json", host_of(clock))
    memory.take(row(), RULE)
    path.unlink()
    clock.now_ns += round(WRITES_S * NS_PER_S) - 1
    memory.take(row(), RULE)
    assert not path.exists()
    clock.now_ns += 1
    memory.take(row(), RULE)
    assert path.exists()


def test_what_the_disk_refuses_is_said_and_tried_again(tmp_path: Path) -> None:
    workers = list[AtOnce]()

    def begin(work: Work) -> Worker:
        workers.append(AtOnce(work))
        return workers[-1]

    folder = tmp_path / "away"
    host = stepped_host(WallClock())._replace(begin_worker=begin)
    memory = NonvolatileMemory(folder / "machine.json", host)
    memory.take(row(), RULE)
    assert "machine.json cannot be written" in memory.lost
    assert len(memory.lost.splitlines()) == 1
    folder.mkdir()
    workers[0].wake()  # a second later
    assert memory.lost == ""
    assert (folder / "machine.json").exists()


def test_whoever_records_waits_for_no_disk_and_an_end_does(tmp_path: Path) -> None:
    may_write = threading.Event()

    class SlowFiles(type(THIS_COMPUTER.files)):  # type: ignore[misc]
        def write(self, path: Path, content: str) -> None:
            may_write.wait(60.0)
            super().write(path, content)

    host = THIS_COMPUTER._replace(files=SlowFiles())
    memory = NonvolatileMemory(path := tmp_path / "machine.json", host)
    for passes in range(3):
        memory.take(row(episode__passes=float(passes)), RULE)
    assert not finish(memory.close(0.05), host.clock)
    may_write.set()
    assert finish(memory.close(60.0), host.clock)
    found = nonvolatile_memory.recall(path, WROTE_NS, 0.0)
    assert found is not None
    assert found.kept.episode.passes == 2  # the newest


def test_a_machine_whose_patient_goes_with_the_computer_keeps_nothing(host: Host) -> None:
    memory = NonvolatileMemory(None, host)
    memory.take(row(), RULE)
    assert memory.lost == ""


def _without_a_field(told: dict[str, object]) -> dict[str, object]:
    kept = told["kept"]
    assert isinstance(kept, dict)
    return {**told, "kept": {name: kept[name] for name in list(kept)[1:]}}


@pytest.mark.parametrize(
    "change",
    [
        lambda _: "",
        lambda _: "[]",
        lambda _: "\xff\xfe",
        lambda text: text[: len(text) // 2],
        lambda text: json.dumps(_without_a_field(json.loads(text))),
        lambda text: json.dumps({**json.loads(text), "phase": 99}),
        lambda text: json.dumps({**json.loads(text), "wall_ns": "yesterday"}),
        lambda text: json.dumps({**json.loads(text), "kept": None}),
    ],
)
def test_one_that_cannot_be_read_is_no_reason_to_forget(
    tmp_path: Path, host: Host, change: Callable[[str], str]
) -> None:
    path = tmp_path / "machine.json"
    NonvolatileMemory(path, host).take(USED, RULE)
    path.write_text(change(path.read_text(encoding="utf-8")), encoding="latin-1")
    with pytest.raises(InputError, match="begin with --anew") as refused:
        recall(path, 0.0)
    assert len(str(refused.value).splitlines()) == 1
    nonvolatile_memory.forget(path)
    assert nonvolatile_memory.recall(path, WROTE_NS, 0.0) is None


def test_a_person_reads_what_is_known_again(tmp_path: Path, host: Host) -> None:
    path = tmp_path / "machine.json"
    NonvolatileMemory(path, host).take(USED, RULE)
    said = nonvolatile_memory.describe(recall(path, 30.0))
    for words in ("somebody looked: 2", "90 s of rest left", "5.0 h old"):
        assert words in said
    NonvolatileMemory(path, host).take(row(Phase.SUCTIONING), RULE)
    assert "broken off in suctioning" in nonvolatile_memory.describe(recall(path, 30.0))


def test_the_disk_has_it_before_it_takes_the_place_of_the_one_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a loss of power at any instant it is the old one or the new one, whole."""
    done = list[str]()
    fsync, replace = os.fsync, Path.replace

    def note_sync(handle: int) -> None:
        done.append("sync")
        fsync(handle)

    def note_replace(path: Path, other: Path) -> Path:
        done.append("replace")
        return replace(path, other)

    monkeypatch.setattr(os, "fsync", note_sync)
    monkeypatch.setattr(Path, "replace", note_replace)
    THIS_COMPUTER.files.write(tmp_path / "machine.json", "{}")
    assert done == ["sync", "replace", "sync", "sync"]  # file; its place; file and folder again
