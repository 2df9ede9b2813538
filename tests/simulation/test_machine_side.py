"""The twin as a process plays it gives what the closed loop gives, to the last bit."""

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import MESSAGE_COLUMNS, START, DriveMessage
from opensuction.kernel.record import make_zero
from opensuction.procedure.planning.protocol import PAPER
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation import machine_side, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import Loop, LoopState
from opensuction.simulation.machine_side import (
    SHOWN_COLUMNS,
    Heard,
    MachineCall,
    MachineSide,
)
from opensuction.simulation.wiring import Wiring
from opensuction.twin import preset
from opensuction.twin.fault import link
from opensuction.twin.machine import fail_safe
from opensuction.twin.plant import PlantState
from opensuction.twin.sensor import sensor


def side_of(loop: Loop) -> MachineSide:
    limited = preset.limit_rack(loop.machine, loop.controller.limits.park_head_mm)
    watchdog = fail_safe.of(limited, loop.controller.limits.park_head_mm)
    return MachineSide(limited, Wiring(link.healthy(1), watchdog))


def call_of(loop: Loop, state: LoopState) -> MachineCall:
    begun = machine_side.begin(side_of(loop), PlantState(state.machine, state.bedside))
    return MachineCall(begun)


def bench() -> tuple[Loop, LoopState]:
    rig = rigs.rig("bench", 1)
    known = rigs.uncalibrated(rig.profile)
    return rigs.assemble(rig, PAPER, CompensationKind.NONE, known, 2)


@pytest.mark.parametrize("patient", ["child-10kg", "neonate"])
def test_under_a_cycles_commands_it_moves_and_reads_as_in_the_closed_loop(patient: str) -> None:
    rig = RigChoice(patient=patient, seed=3)
    choice = CycleChoice(rig, approach="contact", compensation="preview")
    prepared = cycle_run.prepare(resolution.resolve(choice))
    columns = trace.record(prepared.loop, prepared.start, START, 60.0)[1]
    call = call_of(prepared.loop, prepared.start)
    names = [name for name in SHOWN_COLUMNS if name.startswith(("readings.", "truth."))]
    places = [SHOWN_COLUMNS.index(name) for name in names]
    expected = np.stack([columns[name] for name in names], axis=1)
    sent = np.stack(
        [columns.get(name, np.zeros(len(expected))) for name in MESSAGE_COLUMNS], axis=1
    )
    assert np.ptp(columns["truth.tip_mm"]) > 50.0
    for tick in range(len(expected) - 1):
        call.step(sent[tick], new=True)
        # A tick's rows are those before the machine moved, here after: one later.
        assert call.shown_row[places].tobytes() == expected[tick + 1].tobytes(), tick


def shown(call: MachineCall, name: str) -> float:
    return float(call.shown_row[SHOWN_COLUMNS.index(name)])


def sent_row(**values: float) -> np.ndarray:
    row = plain_row.pack(DriveMessage, make_zero(DriveMessage))
    for name, value in values.items():
        row[MESSAGE_COLUMNS.index(name.replace("__", "."))] = value
    return row


PUSHING = sent_row(commands__insertion_v=20.0, commands__insertion_on=1.0, wanted=4.0)


def test_without_a_new_message_for_20_ms_the_drives_bring_the_catheter_out_and_say_so() -> None:
    call = call_of(*bench())
    for _ in range(2000):
        call.step(PUSHING, new=True)
    inside_mm = shown(call, "truth.head_mm")
    assert inside_mm > 20.0
    assert not shown(call, "alone")
    for _ in range(20):
        call.step(PUSHING, new=False)
    assert not shown(call, "annunciator.watchdog_fired")
    for _ in range(2):
        call.step(PUSHING, new=False)
    assert shown(call, "alone")
    assert shown(call, "annunciator.watchdog_fired")
    assert shown(call, "annunciator.said") == 4.0  # what the controller last wanted stays
    for _ in range(8000):
        call.step(PUSHING, new=False)
    assert shown(call, "truth.head_mm") < 1.0


def test_drives_that_act_alone_obey_only_a_controller_that_has_started_anew() -> None:
    call = call_of(*bench())
    for _ in range(30):
        call.step(PUSHING, new=False)
    assert shown(call, "alone")
    call.step(PUSHING, new=True)
    assert shown(call, "alone")
    call.step(sent_row(released=1.0), new=True)
    assert not shown(call, "alone")
    # What was shown stays until a person resets it.
    assert shown(call, "annunciator.watchdog_fired")
    call.step(sent_row(reset=1.0), new=True)
    assert not shown(call, "annunciator.watchdog_fired")


def test_a_message_that_is_late_is_told() -> None:
    call = call_of(*bench())
    call.step(PUSHING, new=True)
    for _ in range(5):
        call.step(PUSHING, new=False)
    assert not shown(call, "annunciator.message_late")
    call.step(PUSHING, new=False)
    assert shown(call, "annunciator.message_late")


def test_a_delay_of_readings_and_messages_is_played() -> None:
    loop, state = bench()
    exact = sensor.exact_sensors(loop.machine.sensors)
    loop = loop._replace(machine=loop.machine._replace(sensors=exact))
    side = side_of(loop)
    wires = side.wiring.link._replace(reading_delay_ticks=3, command_delay_ticks=2)
    delayed = side._replace(wiring=side.wiring._replace(link=wires))
    plain, late = call_of(loop, state), call_of(loop, state)
    late.side_row[:] = plain_row.pack(MachineSide, delayed)
    rows: dict[str, list[float]] = {"plain": [], "late": []}
    for _ in range(300):
        for name, call in (("plain", plain), ("late", late)):
            call.step(PUSHING, new=True)
            rows[name].append(shown(call, "readings.head_mm"))
    assert rows["plain"][:-5] == rows["late"][5:]
    assert rows["plain"][-1] > rows["plain"][0]


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", MESSAGE_COLUMNS)
def test_a_message_with_anything_in_it_that_is_no_number_does_not_count(
    column: str, value: float
) -> None:
    """Neither as a command nor as a greeting."""
    heard = Heard(np.zeros(len(MESSAGE_COLUMNS)), np.zeros(machine_side.HEARD_COUNTS, np.int64))
    bad = np.ones(len(MESSAGE_COLUMNS))
    bad[MESSAGE_COLUMNS.index(column)] = value
    assert not machine_side.hear(heard, 1, bad)
    assert not machine_side.hear(heard, 2, greeting(0.0))
    assert machine_side.hear(heard, 3, greeting(1.0))
    assert not machine_side.hear(heard, 4, bad)
    assert (heard.row == greeting(1.0)).all()


def greeting(released: float) -> np.ndarray:
    """A message with numbers alone. released: 1 from a controller that has started anew."""
    made = np.full(len(MESSAGE_COLUMNS), 0.5)
    made[MESSAGE_COLUMNS.index("released")] = released
    return made
