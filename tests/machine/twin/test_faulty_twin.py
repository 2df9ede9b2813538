"""Faults of a twin that is stepped from outside: as in a simulated run, to the last bit."""

import threading
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from opensuction.ipc.ring import EventReader, RingWriter
from opensuction.kernel.codegen import row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import MESSAGE_COLUMNS
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.twin import twin_faults, twin_machine
from opensuction.machine.twin.faulty_twin import FaultyTwin
from opensuction.machine.twin.twin_faults import PHASE, PHASES, Came
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import machine_side
from opensuction.simulation.injection import injection
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineCall
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.bus import PLAUSIBLE, Bus
from opensuction.twin.fault.fault import Fault
from tests.controller.bedside import at_bed
from tests.simulation.test_machine_side import PUSHING, bench, call_of, side_of

NOTHING = np.zeros(len(MESSAGE_COLUMNS))


class Stand:
    """A twin that is stepped, and people who ask it."""

    def __init__(self, folder: Path, call: MachineCall) -> None:
        self.folder, self.call = folder, call
        self.twin = FaultyTwin(folder, call)

    def ask(self, asked: Callable[[], None]) -> None:
        """Somebody asks, and the twin hears it between two ticks."""
        problem: list[Exception] = []

        def talk() -> None:
            try:
                asked()
            except InputError as error:
                problem.append(error)

        talking = threading.Thread(target=talk)
        talking.start()
        while talking.is_alive():
            self.twin.look()
            talking.join(0.001)
        self.twin.look()
        if problem:
            raise problem[0]

    def inject(self, *names: str) -> None:
        faults = [resolution.parse(name) for name in names]
        self.ask(lambda: twin_faults.inject(self.folder, faults))

    def step(self, sent: Array = NOTHING, new: bool = True) -> None:
        self.twin.look()
        self.twin.step()
        self.call.step(sent, new=new)

    def shown(self, name: str) -> float:
        return float(self.call.shown_row[SHOWN_COLUMNS.index(name)])


@pytest.fixture
def stand(tmp_path: Path) -> Iterator[Stand]:
    made = Stand(tmp_path, call_of(*at_bed("neonate")))
    with made.twin:
        yield made


TRUTH = [name for name in SHOWN_COLUMNS if name.startswith("truth.")]


@cache
def prepared() -> Prepared:
    return cycle_run.prepare(resolution.resolve(CycleChoice(RigChoice(patient="neonate", seed=3))))


def truth_of(columns: Columns) -> Array:
    return np.stack([columns[name] for name in TRUTH], axis=1)


@cache
def healthy() -> Array:
    return truth_of(injection.run(prepared().loop, prepared().start, ()).columns)


@pytest.mark.parametrize(
    "names",
    [
        ("cough@6",),
        ("motor-intermittent@7=0.3",),
        ("line-leak=0.5", "catheter-jammed@6.5"),
        ("message-lost@7=0.4",),
        ("message-late@6=0.02",),
        ("power-lost@8",),
    ],
    ids=str,
)
def test_a_fault_at_an_instant_does_what_it_does_in_a_simulated_cycle(
    tmp_path: Path, names: tuple[str, ...]
) -> None:
    faults = [resolution.parse(name) for name in names]
    run = injection.run(prepared().loop, prepared().start, faults, seed=1)
    expected = truth_of(run.columns)
    zeros = np.zeros(len(expected))
    sent = np.stack([run.sent.get(name, zeros) for name in MESSAGE_COLUMNS], axis=1)
    ticks = min(len(healthy()), len(expected))
    assert not np.array_equal(expected[:ticks], healthy()[:ticks])
    made = Stand(tmp_path, call_of(prepared().loop, prepared().start))
    places = [SHOWN_COLUMNS.index(name) for name in TRUTH]
    with made.twin:
        made.ask(lambda: twin_faults.inject(tmp_path, faults))
        for tick in range(len(expected) - 1):
            made.step(sent[tick])
            # A tick's rows are those before the machine moved, here after: one later.
            found = made.call.shown_row[places]
            assert found.tobytes() == expected[tick + 1].tobytes(), tick
    in_order = sorted(faults, key=lambda one: one.at.after_s)
    assert [one.fault for one in twin_faults.came(tmp_path)] == [one.fault for one in in_order]


def test_a_sensor_is_wrong_from_the_tick_that_was_asked_for(stand: Stand) -> None:
    for _ in range(100):
        stand.step()
    stand.inject("encoder-offset@0.05=5")
    errors = []
    for _ in range(100):
        stand.step()
        errors.append(stand.shown("readings.head_mm") - stand.shown("truth.head_mm"))
    assert np.abs(errors[:50]).max() < 0.5
    assert np.abs(np.array(errors[50:]) - 5.0).max() < 0.5
    assert twin_faults.came(stand.folder) == [Came(Fault.ENCODER_OFFSET, 5.0, 150)]


def test_a_frozen_sensor_shows_what_it_showed_last(stand: Stand) -> None:
    released = PUSHING.copy()
    for _ in range(500):
        stand.step(released)
    before = stand.shown("readings.head_mm")
    stand.inject("encoder-frozen")
    for _ in range(200):
        stand.step(released)
        assert stand.shown("readings.head_mm") == before
    assert stand.shown("truth.head_mm") > before + 1.0


def test_mended_it_is_the_machine_that_it_was(stand: Stand) -> None:
    sound = stand.call.side_row.copy()
    stand.inject("pump-weak", "encoder-invalid@100")
    stand.step()
    assert not np.array_equal(stand.call.side_row, sound, equal_nan=True)
    stand.ask(lambda: twin_faults.heal(stand.folder))
    assert np.array_equal(stand.call.side_row, sound, equal_nan=True)
    for _ in range(100_100):
        stand.twin.step()
    assert np.array_equal(stand.call.side_row, sound, equal_nan=True)
    assert [one.fault for one in twin_faults.came(stand.folder)] == [Fault.PUMP_WEAK]


def test_mains_that_come_back_wait_for_a_controller_that_starts_anew(stand: Stand) -> None:
    stand.inject("power-returning=0.1")
    for _ in range(60):
        stand.step()
    assert stand.shown("annunciator.reserve_used") == 1.0
    for _ in range(60):
        stand.step()
    assert stand.shown("annunciator.reserve_used") == 0.0
    assert stand.shown("alone") == 1.0
    greeting = NOTHING.copy()
    greeting[MESSAGE_COLUMNS.index("released")] = 1.0
    stand.step(greeting)
    assert stand.shown("alone") == 0.0


def write_phases(ring: RingWriter, *phases: Phase) -> None:
    for phase in phases:
        ring.write(np.array([0.0, float(phase)]))


def test_a_fault_waits_for_its_phase_to_begin(stand: Stand) -> None:
    with RingWriter(stand.folder / PHASES, ("loop.time_s", PHASE), 100, {}) as ring:
        write_phases(ring, Phase.SUCTIONING)
        stand.step()
        stand.inject("line-clogged@suctioning+0.01", "pump-lost@withdrawing")
        for _ in range(100):
            write_phases(ring, Phase.SUCTIONING)
            stand.step()
        assert twin_faults.came(stand.folder) == []  # it had begun before anybody asked
        write_phases(ring, Phase.PARKED, Phase.SUCTIONING)
        began = stand.twin.tick
        for _ in range(20):
            stand.step()
            write_phases(ring, Phase.SUCTIONING)
        assert [one[::2] for one in twin_faults.came(stand.folder)] == [
            (Fault.LINE_CLOGGED, began + 9)
        ]
    # Another controller, in the phase that is waited for.
    with RingWriter(stand.folder / PHASES, ("loop.time_s", PHASE), 100, {}) as ring:
        write_phases(ring, Phase.WITHDRAWING)
        for _ in range(100):
            stand.step()
        assert [one.fault for one in twin_faults.came(stand.folder)][1:] == [Fault.PUMP_LOST]


@pytest.mark.parametrize(
    ("names", "what"),
    [
        (("controller-stopped",), "kill its process"),
        (("tick-late",), "kill -STOP"),
        (("catheter-expired",), "set up already"),
        (("taught-too-deep",), "set up already"),
        (("pump-weak=7",), "no strength 7"),
        (("pump-weak@1000",), "less than 180 s"),
        (("pump-weak", "pump-lost", "cough"), "at most 2"),
    ],
    ids=str,
)
def test_what_cannot_be_put_into_a_machine_that_runs_is_refused(
    stand: Stand, names: tuple[str, ...], what: str
) -> None:
    with pytest.raises(InputError, match=what):
        stand.inject(*names)


def test_more_than_two_are_refused_until_they_are_mended(stand: Stand) -> None:
    stand.inject("pump-weak", "cough@50")
    stand.step()
    with pytest.raises(InputError, match="2 faults are there or to come, and 1 more"):
        stand.inject("line-leak")
    stand.ask(lambda: twin_faults.heal(stand.folder))
    stand.inject("line-leak")


def test_what_is_no_request_changes_nothing(stand: Stand) -> None:
    sound = stand.call.side_row.copy()
    with pytest.raises(InputError, match="does not understand"):
        stand.ask(lambda: twin_faults._ask(stand.folder, {"faults": [["nothing", None, 0.0, 0.0]]}))
    with pytest.raises(InputError, match="does not understand"):
        stand.ask(lambda: twin_faults._ask(stand.folder, {"anything": 1}))
    for data in (b"", b"{", b"[]", b"{}", b"\xff" * 100):
        stand.twin._obey(data)
    stand.step()
    assert np.array_equal(stand.call.side_row, sound, equal_nan=True)
    kinds = [
        event.fields["kind"] for event in EventReader(stand.folder / twin_faults.EVENTS).read()[0]
    ]
    assert kinds == ["answer"] * 2


def test_a_bus_is_put_in_while_nothing_is_broken(stand: Stand) -> None:
    stand.ask(lambda: twin_faults.ride(stand.folder, Bus(0.01, 0.0, 0.0)))
    for _ in range(30):
        stand.step(PUSHING)
    assert stand.shown("commands.insertion_v") > 0.0
    assert stand.shown("annunciator.message_late") == 1.0
    stand.inject("pump-weak")
    stand.step()
    with pytest.raises(InputError, match="mend them first"):
        stand.ask(lambda: twin_faults.ride(stand.folder, PLAUSIBLE))
    with pytest.raises(InputError, match="jitter"):
        twin_faults.ride(stand.folder, Bus(0.0, 0.1, 0.0))


@pytest.mark.parametrize(
    ("carrier", "alone"),
    [(Bus(0.015, 0.005, 0.0), False), (Bus(0.03, 0.0, 0.0), True), (Bus(0.0, 0.0, 1.0), True)],
    ids=str,
)
def test_a_bus_that_is_silent_for_longer_than_the_watchdog_leaves_the_drives_to_themselves(
    tmp_path: Path, carrier: Bus, alone: bool
) -> None:
    """The controller sends every tick, whatever comes of it; once they act alone they stay so."""
    stand = Stand(tmp_path, call_of(*bench()))
    with stand.twin:
        for _ in range(1500):
            stand.step(PUSHING)
        inside_mm = stand.shown("truth.head_mm")
        assert inside_mm > 15.0
        stand.ask(lambda: twin_faults.ride(stand.folder, carrier))
        for _ in range(1500):
            stand.step(PUSHING)
        assert stand.shown("alone") == alone
        assert stand.shown("annunciator.watchdog_fired") == alone
        assert stand.shown("annunciator.message_late") == 1.0
        assert (stand.shown("truth.head_mm") < inside_mm - 5.0) == alone


def test_where_no_twin_plays_or_it_does_not_answer_that_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match="no ring at"):
        twin_faults.heal(tmp_path)
    made = Stand(tmp_path, call_of(*at_bed("neonate")))
    monkeypatch.setattr(twin_faults, "PATIENCE_S", 0.05)
    with made.twin, pytest.raises(InputError, match="does not answer"):
        twin_faults.heal(tmp_path)
    with pytest.raises(InputError, match="no twin plays"):
        twin_faults.heal(tmp_path)


def test_another_machine_is_what_faults_come_to(stand: Stand) -> None:
    side = side_of(at_bed("neonate")[0])
    deeper = side.machine.airway._replace(carina_mm=99.0)
    stand.inject("pump-weak")
    stand.step()
    stand.ask(
        lambda: twin_machine.change(
            stand.folder, side._replace(machine=side.machine._replace(airway=deeper))
        )
    )
    names = row.columns(machine_side.MachineSide)
    place = names.index("machine.airway.carina_mm")
    assert stand.call.side_row[place] == 99.0
    stand.inject("carina-missed")
    stand.step()
    assert stand.call.side_row[place] > 99.0
