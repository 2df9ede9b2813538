"""Least exposure after a fault: of a catheter drawn out at once with the drive's whole voltage.

No controller tells a fault of the drive from friction and noise before `NOTICE_S`, and none has
more than the supply's voltage. Where this withdrawal, too, takes longer than a bound of time
allows, no controller could have kept that bound. It is played on the faulty machine, without a
controller: for `NOTICE_S` what the drives obeyed in the run, then the motor outwards until the tip
is out, the valve shut and the pump off.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.kernel.compiled import compiled
from opensuction.kernel.compiler.dispatcher import TypedCall
from opensuction.kernel.interface import Commands
from opensuction.oracle import exposure
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.twin import plant
from opensuction.twin.fault.fault_row import MachineEffect
from opensuction.twin.fault.fault_table import ROWS
from opensuction.twin.machine import machine as machine_model
from opensuction.twin.machine.machine import Machine
from opensuction.twin.plant import PlantState

NOTICE_S = 0.05
"""[design] Time in which a fault of the drive can show: the head's speed is averaged over 10 ms,
what works against the motor over 30."""
VOLTS, TORQUE = "commands.insertion_v", "commands.insertion_on"
LONGEST_S = 60.0
"""A catheter that is not out by then counts as inside for ever: no bound of time is longer."""


class LeastExposure(NamedTuple):
    """Times that a patient cannot be spared, over the whole run."""

    in_airway_s: float
    """Infinite where the tip stays inside."""
    contact_s: float


@compiled
def _withdraw(
    machine: Machine,
    state: PlantState,
    obeyed: npt.NDArray[np.float64],
    outside_mm: float,
    most: int,
) -> tuple[int, int, bool]:
    """Ticks in the airway, ticks with contact, and whether the tip came out.

    obeyed: volts of the insertion motor in the first ticks, nan without torque. most: ticks that
    are played at most.
    """
    outwards_v = -machine.insertion_axis.voltage_limit_v * machine.insertion_axis.polarity
    done, inside, touching, out = 0, 0, 0, False
    while done < most and not out:
        now = machine_model.truth(machine, state.machine)
        if now.tip_mm > outside_mm:
            inside += 1
        if now.contact_n > exposure.TOUCHING_N:
            touching += 1
        volts = obeyed[done] if done < obeyed.size else outwards_v
        out = done >= obeyed.size and now.tip_mm <= outside_mm
        commands = Commands(
            head_mm=0.0,
            insertion_v=0.0 if math.isnan(volts) else volts,
            insertion_on=not math.isnan(volts),
            cam_rad=0.0,
            valve_v=0.0,
            valve_on=False,
            pump_on=False,
            vacuum_mmhg=0.0,
        )
        state = plant.step(machine, state, commands, DT_S)
        done += 1
    return inside, touching, out


_play = TypedCall(_withdraw, lambda *_: 0)


def find(machine: Machine, run: InjectedRun) -> LeastExposure | None:
    """Least exposure of a run with one fault of the machine that lasts from its instant on.

    machine: as it was built, before the fault. run: its columns are at least `exposure.COLUMNS`
    and the insertion motor's commands. None for a run with other or more faults.
    """
    columns = run.columns
    came = [place for place, one in enumerate(run.faults) if not math.isnan(one.at_s)]
    if len(came) != 1 or not run.before:
        return None
    one, was = run.faults[came[0]], run.before[came[0]]
    row = ROWS[one.injection.fault]
    if was is None or not isinstance(row.effect, MachineEffect) or row.course is not None:
        return None
    begun = round(one.at_s / DT_S)
    before = {name: columns[name][:begun] for name in exposure.COLUMNS}
    lasted_s = touched_s = 0.0
    if begun:
        borne = exposure.measure(machine, before)
        lasted_s, touched_s = borne.in_airway_s, borne.contact_s
    noticed = slice(begun, begun + round(NOTICE_S / DT_S))
    volts = np.where(
        columns[TORQUE][noticed] > 0.0,
        columns[VOLTS][noticed],
        math.nan,
    )
    faulty = row.change_machine(machine, one.injection.strength)
    state = PlantState(was.machine, was.bedside)
    outside_mm = exposure.outside_mm(machine, columns["truth.tip_mm"])
    inside, touching, out = _play(faulty, state, volts, outside_mm, round(LONGEST_S / DT_S))
    in_airway_s = lasted_s + inside * DT_S if out else math.inf
    return LeastExposure(in_airway_s, touched_s + touching * DT_S)
