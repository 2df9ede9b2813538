"""The closed loop with a link between its sides that can fail, and drives that watch over it.

With a healthy link it gives the rows of `opensuction.simulation.closed_loop`; it is compiled only
when a fault of sensors, messages, power or controller is injected. While no controller runs, the
rows say that the machine has halted.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.controller import controller
from opensuction.controller.record import Inputs, Outputs, State
from opensuction.kernel import row
from opensuction.kernel.compiled import compiled
from opensuction.kernel.phase import RESTING, Phase
from opensuction.kernel.requests import NO_REQUESTS, Host, Requests
from opensuction.simulation.closed_loop import DT_S, Loop, LoopState, TraceRow
from opensuction.twin import plant
from opensuction.twin.fault import link
from opensuction.twin.fault.link import Link, LinkState, Ring
from opensuction.twin.machine import drive_watchdog, machine
from opensuction.twin.machine.drive_watchdog import DriveWatchdog, WatchdogState
from opensuction.twin.machine.machine import MachineState

_write = row.writer(TraceRow)


class Linked(NamedTuple):
    """A loop whose sides are linked, and what watches over the drives."""

    loop: Loop
    link: Link
    watchdog: DriveWatchdog


class Between(NamedTuple):
    """State of what lies between controller and machine."""

    link: LinkState
    watchdog: WatchdogState
    outputs: Outputs
    """The controller's last."""


@compiled
def _tick(
    linked: Linked,
    tick: int,
    state: State,
    body: MachineState,
    between: Between,
    requests: Requests,
    got: Ring,
    sent: Ring,
) -> tuple[State, MachineState, Between, TraceRow]:
    """One tick of controller, link, drives and machine; the bedside stands still."""
    loop = linked.loop
    reported = link.sense(linked.link, machine.read(loop.machine, body), tick)
    readings = link.receive_readings(linked.link, between.link, reported, got, tick)
    truth = machine.truth(loop.machine, body)
    decided, outputs = state, between.outputs
    if linked.link.controller_runs:
        inputs = Inputs(
            tick=tick,
            dt_s=DT_S,
            readings=readings,
            requests=requests,
            host=Host(overrun=tick < linked.link.late_until_tick, conditions=0),
        )
        decided, outputs = controller.step(loop.controller, state, inputs)
    obeyed, heard = link.receive_commands(linked.link, between.link, outputs.commands, sent, tick)
    received = LinkState(readings=readings, commands=obeyed)
    watchdog = drive_watchdog.step(
        linked.watchdog, between.watchdog, heard, linked.link.mains, reported.head_mm, DT_S
    )
    if watchdog.alone:
        obeyed = drive_watchdog.commands(
            linked.watchdog,
            watchdog,
            linked.link.mains or linked.link.reserve,
            reported.head_mm,
            reported.cam_rad,
        )
    moved = machine.step(loop.machine, body, obeyed, DT_S)
    record = TraceRow(
        time_s=tick * DT_S,
        phase=outputs.phase if linked.link.controller_runs else Phase.HALTED,
        cause=outputs.cause,
        check_item=outputs.check_item,
        check_failed=outputs.check_failed,
        readings=readings,
        demand=outputs.demand,
        verdict=outputs.verdict,
        signals=outputs.signals,
        commands=obeyed,
        truth=truth,
    )
    return decided, moved, Between(received, watchdog, outputs), record


@compiled
def run(
    linked: Linked,
    state: LoopState,
    between: Between,
    requests: Requests,
    trace: npt.NDArray[np.float64],
    got: Ring,
    sent: Ring,
) -> tuple[LoopState, Between, int]:
    """Run until the trace is full or the machine comes to rest, as `closed_loop.run` does.

    got, sent: the rings of readings and commands, written.
    """
    active = state.controller.procedure.phase not in RESTING
    tick, decided, body, bedside = state.tick, state.controller, state.machine, state.bedside
    done, at_rest = 0, False
    while done < trace.shape[0] and not at_rest:
        decided, body, between, record = _tick(
            linked, tick, decided, body, between, requests, got, sent
        )
        requests = NO_REQUESTS
        _write(trace[done], record)
        tick += 1
        done += 1
        at_rest = active and between.outputs.phase in RESTING
        active = between.outputs.phase not in RESTING
        if plant.is_due(body):
            body, bedside = plant.settle(linked.loop.machine, body, bedside, DT_S)
    return LoopState(tick, decided, body, bedside), between, done


def blank(record_type: type) -> npt.NDArray[np.float64]:
    """Columns of a record in which everything is 0."""
    return np.zeros(len(row.columns(record_type)))


_first_outputs = row.reader(Outputs)


@compiled
def silent(columns: npt.NDArray[np.float64]) -> Outputs:
    """Outputs of a controller that has said nothing yet, from `blank` columns."""
    found: Outputs = _first_outputs(columns)
    return found
