"""Controller and recorder on a machine that is no twin: they work, and say what it lacks.

No process and no clock: both run here, and are told to end after so many ticks or looks.
"""

import json
from contextlib import nullcontext
from pathlib import Path

import pytest

from opensuction.controller.configuration import Configuration
from opensuction.host.host import Allowed, Host, finish
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.mailbox import Sender
from opensuction.ipc.ring import EventReader, RingReader
from opensuction.kernel.vocabulary import NOT_A_DEVICE
from opensuction.machine import port
from opensuction.machine.port import EVERYTHING, NOTHING, Description, describe
from opensuction.recording.cycle_file.frame import NOTICE
from opensuction.recording.cycle_file.reader import RecordingReader
from opensuction.records.records import Records
from opensuction.runtime import (
    control_process,
    launch,
    machine_folder,
    recorder_process,
)
from opensuction.runtime.control_process import say_lacking
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import ASK, EVENTS, RING
from tests.controller.bedside import at_bed
from tests.machine import bare_machine
from tests.machine.bare_machine import MACHINE_FACTS
from tests.runtime.identity import ABOUT

TICKS = 600
PRESSED_AT = {20: "assessed", 40: "oxygen_skipped", 60: "start"}
LOOP = at_bed("neonate")[0]
CHOSEN = Configuration(LOOP.controller, LOOP.heads_mm)
EXPECTED = (
    "patient monitor (the settings go by it), light barrier at the tube's mouth (the settings go "
    "by it), teaching by hand, simulated hand, truth for a judge, faults on request"
)


class Ending:
    """Counts how often a process was told to end."""

    def __init__(self) -> None:
        self.asked = 0

    @property
    def host(self) -> Host:
        """This computer, without real-time rights."""
        return THIS_COMPUTER._replace(
            terminations=lambda: self.asked,
            hardened=lambda: nullcontext(Allowed("other", False, ())),
        )


class CountedPace:
    """Ticks one after the other, with a person at the buttons; then the end."""

    def __init__(self, folder: Path, ending: Ending) -> None:
        self.deadline_ns, self._tick, self._ending = 0, 0, ending
        self._person = Sender(folder / ASK, "nurse")

    @property
    def due_ns(self) -> int:
        return self.deadline_ns + 1_000_000

    def begin(self, now_ns: int) -> int:  # noqa: ARG002
        self._tick += 1
        self.deadline_ns += 1_000_000
        if (button := PRESSED_AT.get(self._tick)) is not None:
            self._person.ask(button, button, "2026-11-27T12:00:00Z")
        if self._tick == TICKS:
            self._person.close()
            self._ending.asked += 1
        return 0


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """In which a controller has worked and ended."""
    bare_machine.prepare(tmp_path, monkeypatch)
    launch.configure(tmp_path, CHOSEN)
    about = ABOUT._replace(
        machine=ABOUT.machine._replace(serial="bare-1", is_twin=False),
        database=str(tmp_path / "records.db"),
    )
    machine_folder.write(tmp_path, about)
    ending = Ending()
    for _ in control_process.steps(
        ending.host, tmp_path, pace=lambda *_: CountedPace(tmp_path, ending)
    ):
        pass
    return tmp_path


def record(folder: Path) -> Path:
    """What a recorder keeps of it: it looks once, and is told to end."""
    ending, out = Ending(), folder / "out"
    steps = recorder_process.steps(ending.host, folder, out)
    next(steps)
    ending.asked += 1
    finish(steps, THIS_COMPUTER.clock)
    (recording,) = out.glob("*.mcap")
    return recording


def test_the_controller_starts_and_says_what_the_machine_lacks(folder: Path) -> None:
    ring = RingReader(folder / RING)
    began, *_ = (one.fields for one in EventReader(folder / EVENTS).read()[0])
    assert (began["kind"], began["lacks"]) == ("began", EXPECTED)
    assert port.read_description(ring.facts.told) == Description(False, NOTHING)
    assert json.loads(ring.facts.told["machine"])["name"] == "bare"
    ticks = ring.drain().rows[:, ROW_COLUMNS.index("inputs.tick")]
    assert list(ticks[:TICKS]) == list(range(TICKS))


def test_the_recorder_keeps_it_and_names_no_twin(folder: Path) -> None:
    reader = RecordingReader(record(folder))
    about = reader.heading.about
    reader.close()
    assert about["disclaimer"] == NOT_A_DEVICE
    assert "notice" not in about
    assert about["lacks"] == ", ".join(NOTHING.lacking)
    with Records.open(str(folder / "records.db")) as records:
        found = records.history.list_actions(limit=100)
        (cycle,) = records.history.list_cycles("bare-1")
    (began,) = [one for one in found if one.what == "controller-began"]
    assert f"the machine lacks: {EXPECTED}" in began.detail
    assert cycle.ended_at is not None


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({}, {"notice": NOTICE}),
        (
            {"machine": describe(MACHINE_FACTS._replace(in_silico=True, capabilities=EVERYTHING))},
            {"notice": NOTICE},
        ),
        ({"machine": "{"}, {"disclaimer": NOT_A_DEVICE}),
    ],
    ids=["older", "twin", "not described"],
)
def test_a_recording_says_what_machine_it_was_made_on(
    told: dict[str, str], said: dict[str, str]
) -> None:
    found = recorder_process._heading(told)
    lacks = found.pop("lacks", "")
    assert found == said
    assert ("does not describe its machine" in lacks) == ("disclaimer" in said)


@pytest.mark.parametrize(
    ("lacking", "said"),
    [
        ((), ""),
        (("truth", "faults"), "truth for a judge, faults on request"),
        (("monitor",), "patient monitor (the settings go by it)"),
    ],
)
def test_what_the_settings_go_by_is_said_beside_it(lacking: tuple[str, ...], said: str) -> None:
    has = EVERYTHING._replace(**dict.fromkeys(lacking, False))
    assert say_lacking(has, CHOSEN) == said


def test_a_machine_without_what_nobody_goes_by_is_said_plainly() -> None:
    limits = LOOP.controller.limits
    alone = limits._replace(patient=limits.patient._replace(monitored=False), mouth_mm=float("inf"))
    chosen = CHOSEN._replace(settings=LOOP.controller._replace(limits=alone))
    has = EVERYTHING._replace(monitor=False, mouth_barrier=False)
    assert say_lacking(has, chosen) == "patient monitor, light barrier at the tube's mouth"
