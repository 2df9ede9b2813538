"""A machine whose twin died: how its end is told, and what the next one under its name keeps."""

import os
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from opensuction.cli import entry
from opensuction.cli.command import serve
from opensuction.cli.command.run import MachineOptions
from opensuction.cli.interruption import Stopped
from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller
from opensuction.host import this_computer
from opensuction.host.host import NS_PER_S
from opensuction.ipc.ring import RingWriter
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.machine.twin import twin_machine
from opensuction.runtime import controller_memory, machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.running import console_settings, machine
from opensuction.session.running.machine import Running

NAME = f"test-lost-{os.getpid()}"
REST_S, OFF_S = 900.0, 100.0


@pytest.fixture(scope="module")
def prepared() -> Prepared:
    choice = CycleChoice(RigChoice("bench"), compensation=name_of(CompensationKind.NONE))
    return cycle_run.prepare(resolution.resolve(choice))


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Of machines whose twin is no process, so that none answers."""
    monkeypatch.setattr(twin_machine, "start", lambda *_: None)
    monkeypatch.setattr(this_computer._Clock, "monotonic_ns", lambda _: round(OFF_S * NS_PER_S))
    made = machine_folder.make(NAME)
    yield made
    machine_folder.clear(made)
    made.rmdir()


def leave(folder: Path, tip_mm: float, phase: Phase = Phase.HALTED) -> None:
    """What a controller leaves whose machine has died, `OFF_S` ago."""
    row = dict.fromkeys(ROW_COLUMNS, 0.0)
    row["state.core.upkeep.episode.rest_left_s"] = REST_S
    row["state.core.upkeep.episode.passes"] = 2.0
    row["state.core.procedure.phase"] = float(phase)
    for name in ("foremost_mm", "rearmost_mm"):
        row[f"state.core.governor.watch.tip.{name}"] = tip_mm
    with closing(RingWriter(folder / machine_folder.RING, ROW_COLUMNS, 4, {})) as ring:
        ring.write(np.array(list(row.values())))


def begin(prepared: Prepared, anew: bool = False) -> Running:
    return machine.begin(NAME, prepared, None, anew)


@pytest.mark.parametrize(("tip_mm", "is_inside"), [(60.0, True), (-500.0, False)])
def test_the_rest_is_kept_and_another_patient_is_told(
    prepared: Prepared, folder: Path, tip_mm: float, is_inside: bool
) -> None:
    assert begin(prepared).lost is None
    leave(folder, tip_mm)
    lost = begin(prepared).lost
    assert lost is not None
    assert len(lost.succession.splitlines()) == 1
    assert "another patient" in lost.succession
    assert "800 s of rest are kept" in lost.succession
    assert ("last inside" in lost.succession) == is_inside

    # As the controller of the new machine begins, at home: it knows where the other one was.
    before = controller_memory.read_before(folder)
    assert before is not None
    settings = prepared.loop.controller
    state = controller.restart(
        settings, settings.limits.park_head_mm, before.kept, before.off_s, before.phase
    )
    kept = state.core.upkeep.episode
    assert kept.rest_left_s == pytest.approx(REST_S - OFF_S)
    assert kept.passes == 2
    assert (state.core.procedure.phase == Phase.HALTED) == is_inside
    assert (state.core.reasons != 0) == is_inside, "an alarm says it"


def test_it_outlives_an_end_in_which_the_machine_does_not_answer(
    prepared: Prepared, folder: Path
) -> None:
    begun = begin(prepared)
    leave(folder, 60.0)
    begun.end()
    assert [one.name for one in folder.iterdir()] == [machine_folder.BEFORE]
    lost = begin(prepared).lost
    assert lost is not None
    assert lost.was_inside
    assert lost.rest_left_s == pytest.approx(REST_S - OFF_S)
    assert begin(prepared, anew=True).lost is None


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"kept": [1], "ended_s": 0, "phase": 0}'])
def test_what_cannot_be_read_is_nothing(folder: Path, text: str) -> None:
    (folder / machine_folder.BEFORE).write_text(text)
    assert controller_memory.read_before(folder) is None
    assert machine.find(folder) is None


@pytest.mark.parametrize(
    ("tip_mm", "words", "status"),
    [
        (60.0, "did not answer any more, and the catheter's tip was last inside", 1),
        (-500.0, "did not answer any more; the catheter's tip was last outside", 1),
        (None, "ended in order", entry.DONE),
    ],
)
def test_serve_says_how_it_ended(
    prepared: Prepared,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    tip_mm: float | None,
    words: str,
    status: int,
) -> None:
    said: list[str] = []
    begun = begin(prepared)
    if tip_mm is not None:
        leave(folder, tip_mm)

    @contextmanager
    def machine_of(_: object) -> Iterator[tuple[Running, Path, object]]:
        yield begun, folder / "out", SimpleNamespace(tell=said.append)

    def supervise(*_: object) -> None:
        raise Stopped(15)

    for name in ("check", "find_place", "write"):
        monkeypatch.setattr(console_settings, name, lambda *_: None)
    monkeypatch.setattr(serve, "machine_of", machine_of)
    monkeypatch.setattr(serve, "supervise", supervise)
    monkeypatch.setattr(serve, "Greeting", lambda *_: SimpleNamespace(look=lambda _starting: None))
    options = serve.ServeOptions(machine=MachineOptions(name=NAME))
    assert serve.serve(options) == status
    assert words in said[-1]
