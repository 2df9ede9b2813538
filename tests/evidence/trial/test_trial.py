"""Random faults: no command invariant breaks, no bound under one fault; nothing false is said."""

import json
import os
import signal
import threading
from pathlib import Path
from typing import Any

import pytest

from opensuction.evidence import worker_pool
from opensuction.evidence.campaign import played_cycle
from opensuction.evidence.trial import judged_cycle, trial, trial_page, trial_summary
from opensuction.evidence.trial.judged_cycle import Case
from opensuction.evidence.trial.trial import Part, PlayedPart
from opensuction.evidence.trial.trial_summary import Effort
from opensuction.kernel.errors import InputError
from opensuction.result.plain import to_json
from opensuction.result.trial_result import FaultCount, Trial

SUITE = Trial(seed=900)
"""Away from the seeds that were looked at while limits were set, as the other one."""
SHARE = 40
"""Cycles of it that do not wait for the long runs."""
SOAK = Trial(seed=2000)


def play(chosen: Trial, first: int, last: int) -> list[Case]:
    """The cycles of these numbers, machine after machine."""
    found = [trial.play(one) for one in trial.list_parts(chosen, last)]
    cases = [case for one in found for case in one.cases]
    return sorted(case for case in cases if case.number >= first)


def assert_held(cases: list[Case]) -> None:
    """What no cycle may break."""
    broken = trial_summary.list_violations(SUITE, cases)
    claimed = [one for one in broken if one.is_command or one.counted < 2]
    assert claimed == []
    assert [(case.number, case.false_alarms) for case in cases if case.false_alarms] == []


@pytest.mark.parametrize("faults", ["single", pytest.param("double", marks=pytest.mark.sweep)])
def test_no_invariant_breaks_under_faults_nor_a_bound_under_one(faults: FaultCount) -> None:
    """Two faults break some bounds: that is counted, and not claimed."""
    cases = play(SUITE._replace(faults=faults), 1, SHARE)
    assert [case.number for case in cases] == [*range(1, SHARE + 1)]
    assert_held(cases)
    counted = [case.counted for case in cases]
    # Nothing is drawn in vain: a fault comes while the tip is inside, or about to be.
    assert 0 not in counted
    assert counted.count(1) == SHARE or (faults == "double" and counted.count(2) > SHARE / 2)


@pytest.mark.soak
@pytest.mark.parametrize("faults", ["single", "double"])
def test_no_invariant_breaks_in_many_more(faults: FaultCount) -> None:
    assert_held(play(SUITE._replace(faults=faults), SHARE + 1, 400))


@pytest.mark.parametrize(
    ("compensation", "seed"),
    [("preview", 900), pytest.param("exact-inverse", 901, marks=pytest.mark.soak)],
)
def test_a_sound_cycle_trips_nothing_and_tells_nothing(compensation: str, seed: int) -> None:
    """Every patient by both approaches, each on a machine of its own."""
    cases = play(Trial(faults="none", seed=seed, compensation=compensation), 1, 8)
    assert len({(case.patient, case.approach) for case in cases}) == 8
    assert_held(cases)
    assert all(case.completed for case in cases)


def test_a_cycle_can_be_played_again_alone() -> None:
    """By its number, with all that it came to."""
    chosen = Trial(faults="double", seed=900, cohort="neonate")
    (case,) = play(chosen, 5, 5)
    played = trial.play_again(chosen, 5)
    again = judged_cycle.judge(5, played)
    for name in ("number", "faults", "completed", "commands", "breaches", "left_inside"):
        assert getattr(again, name) == getattr(case, name)
    assert again.endpoints == pytest.approx(case.endpoints, rel=1e-3)
    assert again.watched_s == played_cycle.WATCHED_S
    assert played.run.columns["truth.laser_mm"].size == played.run.columns["phase"].size


def test_more_cycles_begin_with_the_same_ones() -> None:
    chosen = Trial(seed=900, cohort="neonate")
    assert play(chosen, 1, 6)[:3] == play(chosen, 1, 3)


class Folder:
    """A trial of four parts in a folder; each part is a word for it."""

    def __init__(self, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.path = path
        self.heading = trial.make_heading(Trial(faults="none"), 4)
        self.played: list[int] = []
        monkeypatch.setattr(trial, "warm_up", lambda _: None)
        monkeypatch.setattr(worker_pool, "spread", self._spread)
        trial.begin(path, self.heading)

    def _spread(self, _: Any, tasks: list[Part], __: int, tell: Any, ___: Any) -> None:
        for number, task in enumerate(tasks):
            self.played.append(task.machine)
            tell(number, PlayedPart(task.machine, (), ()))

    def run(self) -> list[PlayedPart]:
        kept = trial.go_on(self.path, self.heading)
        return trial.run(self.path, self.heading, kept, workers=1)


def test_what_was_played_is_not_played_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = Folder(tmp_path, monkeypatch)
    for machine in (0, 2):
        trial.keep(tmp_path, PlayedPart(machine, (), ()))
    assert [one.machine for one in folder.run()] == [0, 1, 2, 3]
    assert folder.played == [1, 3]
    assert [one.machine for one in folder.run()] == [0, 1, 2, 3]
    assert folder.played == [1, 3]


def test_a_full_disk_loses_nothing_that_was_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, keep = Folder(tmp_path, monkeypatch), trial.keep

    def fill(path: Path, played: PlayedPart) -> None:
        if played.machine == 2:
            raise OSError(28, "No space left on device", str(path))
        keep(path, played)

    monkeypatch.setattr(trial, "keep", fill)
    with pytest.raises(OSError, match="No space left"):
        folder.run()
    monkeypatch.setattr(trial, "keep", keep)
    assert [one.machine for one in folder.run()] == [0, 1, 2, 3]
    assert folder.played == [0, 1, 2, 2, 3]


def find_workers() -> list[int]:
    """Processes that work for this one."""
    found = []
    for file in Path("/proc/self/task").glob("*/children"):
        for number in file.read_text().split():
            if b"evidence.worker" in Path(f"/proc/{number}/cmdline").read_bytes():
                found.append(int(number))
    return found


@pytest.mark.sweep
@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="no /proc on this system")
def test_a_process_that_is_killed_takes_nothing_along(tmp_path: Path) -> None:
    """The rest goes on, with the same cycles as ever."""
    heading = trial.make_heading(Trial(faults="none", cohort="neonate"), 2)
    trial.begin(tmp_path, heading)
    killed: list[int] = []
    warned: list[str] = []
    is_over = threading.Event()

    def kill() -> None:
        """Kill the first process that works for this one."""
        while not killed and not is_over.is_set():
            for number in find_workers()[:1]:
                os.kill(number, signal.SIGKILL)
                killed.append(number)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    found = trial.run(tmp_path, heading, {}, 1, trial.Listener(warn=warned.append))
    is_over.set()
    killer.join()
    assert len(killed) == 1
    assert warned == ["A process was killed by signal 9: another one does its task anew"]
    assert found == [trial.play(one) for one in trial.list_parts(heading.trial, 2)]
    assert len(found) == 2
    assert trial.list_found(trial.read(tmp_path).parts) == found


@pytest.mark.soak
@pytest.mark.parametrize(
    ("faults", "cycles"), [("none", 2_000), ("single", 50_000), ("double", 50_000)]
)
def test_a_long_trial_holds(faults: FaultCount, cycles: int) -> None:
    """One that was cut off goes on where it was; begun by other sources it begins anew."""
    heading = trial.make_heading(SOAK._replace(faults=faults), cycles)
    folder = Path("runs") / "soak" / f"trial-{faults}"
    folder.mkdir(parents=True, exist_ok=True)
    try:
        kept = trial.go_on(folder, heading)
    except InputError:
        trial.begin(folder, heading)
        kept = {}
    parts = trial.run(folder, heading, kept, os.cpu_count() or 1)
    effort = Effort(os.cpu_count() or 1, 1.0, 0, "of this run")
    found = trial_summary.summarise(heading, parts, effort)
    (folder / "trial.json").write_text(json.dumps(to_json(found), indent=2) + "\n")
    (folder / "trial.md").write_text(trial_page.markdown(found))
    assert_held([case for one in parts for case in one.cases])
