"""The control loop as a process, before the twin: both are what a machine would be."""

import signal
from collections.abc import Iterator

import numpy as np
import pytest

from opensuction.ipc.ring import EventReader
from opensuction.kernel.vocabulary import Phase
from opensuction.runtime import launch
from opensuction.runtime.control_process import PERIOD_NS
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import EVENTS
from tests.runtime.room import INSIDE_MM, Room
from tests.runtime.simulated_room import SimulatedRoom, simulated


@pytest.fixture
def room() -> Iterator[SimulatedRoom]:
    with simulated() as made:
        yield made


def test_a_person_starts_a_cycle_and_it_is_done(room: SimulatedRoom) -> None:
    seen: list[Phase] = []

    def is_done() -> bool:
        rows = room.rows.read().rows
        seen.extend(Phase(int(value)) for value in rows[:, ROW_COLUMNS.index("outputs.phase")])
        return Phase.CLOSING in seen and seen[-1] == Phase.PARKED

    room.reach(is_done)
    assert Phase.SUCTIONING in seen
    assert room.truth("truth.secretion_removed_ml") > 0.0
    assert room.is_out()
    events = EventReader(room.folder / EVENTS).read()[0]
    told = [
        (one.fields["kind"], one.fields.get("ask"), one.fields.get("verdict")) for one in events
    ]
    assert told[0] == ("began", None, None)
    assert ("request", "start", "pressed") in told


def test_killed_in_the_airway_the_drives_bring_it_out_and_the_next_one_waits_for_a_person(
    room: SimulatedRoom,
) -> None:
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    passes = room.now("outputs.counters.passes")
    room.stop()
    assert room.wait(lambda: room.truth("annunciator.watchdog_fired") == 1.0, 1.0)
    room.begin()
    assert room.wait(room.is_out)
    assert room.wait(lambda: room.phase() in (Phase.HALTED, Phase.PARKED))
    first = EventReader(room.folder / EVENTS).read()[0][0]
    assert first.fields["recovered"] == "yes"
    assert room.now("outputs.counters.passes") >= passes  # power cycling does not reset limits
    # Whoever had been told stays told until a person resets it.
    assert room.truth("annunciator.watchdog_fired") == 1.0


def test_told_to_end_in_a_cycle_it_comes_out_first(room: SimulatedRoom) -> None:
    room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
    assert room.control is not None
    room.control.send_signal(signal.SIGTERM)
    assert room.ended(room.control, 20.0) == 0
    assert room.is_out()
    assert EventReader(room.folder / EVENTS).read()[0][-1].fields["kind"] == "ended"


def test_a_machine_that_says_nothing_any_more_is_a_fault_within_a_tenth_of_a_second(
    room: SimulatedRoom,
) -> None:
    assert room.twin is not None
    room.twin.send_signal(signal.SIGSTOP)
    try:
        assert room.wait(lambda: room.now("inputs.readings.head_valid") == 0.0, 1.0)
        assert room.wait(lambda: room.now("outputs.verdict.trips") != 0.0, 1.0)
    finally:
        assert room.twin is not None
        room.twin.send_signal(signal.SIGCONT)


def test_a_second_controller_is_refused_in_a_line(room: SimulatedRoom) -> None:
    second = launch.spawn(room.folder, launch.CONTROL, str(PERIOD_NS), host=room.host)
    assert room.ended(second, 5.0) == 1
    assert room.control is not None
    said = launch.log_of(room.folder, launch.CONTROL).read_text()
    assert f"a controller runs already: process {room.control.pid}, by " in said
    assert said.count("\n") == 1
    ticks = room.now("inputs.tick")
    assert room.wait(lambda: room.now("inputs.tick") > ticks, 1.0)


def test_ticks_come_by_the_clock_and_what_is_missed_is_counted(room: Room) -> None:
    room.rest(1.0)
    assert room.control is not None
    room.signal(room.control.pid, signal.SIGSTOP)
    room.rest(0.004)
    room.signal(room.control.pid, signal.SIGCONT)
    room.rest(1.0)
    rows = room.rows.read().rows
    columns = {name: rows[:, i] for i, name in enumerate(ROW_COLUMNS)}
    steps = np.diff(columns["loop.time_s"])
    assert steps == pytest.approx(1e-3 * (1.0 + columns["loop.skipped"][1:]), abs=1e-6)
    assert (columns["inputs.dt_s"] == 1e-3).all()
    late = columns["inputs.host.overrun"] == 1.0
    assert (late == (columns["loop.skipped"] > 0)).all()
    assert late.any()
    assert (np.diff(columns["inputs.tick"]) == 1.0).all()
    assert np.median(columns["loop.computed_s"]) < 0.5e-3
