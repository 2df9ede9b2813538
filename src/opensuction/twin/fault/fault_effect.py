"""What a fault does to a machine: the same machine with other parameters.

A run swaps the record at the instant; nothing of the twin's tick knows of faults. Whatever a
fault leaves out of account in the state, such as a slide that does not move, follows from the
parameters at the next tick.
"""

from collections.abc import Callable

from opensuction.kernel.errors import InputError
from opensuction.twin.fault import patient_fault
from opensuction.twin.fault.fault import Fault, Means
from opensuction.twin.fault.fault_table import KINDS
from opensuction.twin.machine.catheter import BLASIUS_POWER
from opensuction.twin.machine.dc_axis import DcAxis
from opensuction.twin.machine.machine import Machine
from opensuction.twin.machine.transmission import bundle
from opensuction.twin.patient.patient import Patient

SEIZED_V = 1.0e6
"""Friction that no drive overcomes, and every motion ends in at once."""
NEVER_N = 1.0e9
"""Force that nothing reaches."""
PARTED_MM = 1.0e9
"""Play across which nothing is moved."""
ALWAYS_S = 1.0e9
KINK_N = 3.0
"""[assumed] Friction of a catheter that is kinked flat, at the head."""
KINK_MM = 15.0
"""[assumed] Head travel that a catheter kinked flat gives way before it moves on."""
GAS_LEFT = 0.05
"""[assumed] Share of the canister's volume that is gas when its float has shut."""
TICK_S = 0.001
"""Shortest bounce that is simulated."""


def _insertion(machine: Machine, axis: DcAxis) -> Machine:
    return machine._replace(insertion_axis=axis)


def _switch(machine: Machine, close_n: float, open_n: float) -> Machine:
    return machine._replace(switch=machine.switch._replace(close_n=close_n, open_n=open_n))


def _switch_stuck_open(machine: Machine, _strength: float) -> Machine:
    return _switch(machine, NEVER_N, NEVER_N)


def _switch_stuck_closed(machine: Machine, _strength: float) -> Machine:
    stuck = _switch(machine, -1.0, -1.0)
    return stuck._replace(switch=stuck.switch._replace(bounce_s=0.0))


def _switch_bridged(machine: Machine, strength: float) -> Machine:
    """Pressed for good, and chattering for good: closed in that share of the ticks."""
    stuck = _switch(machine, -1.0, -1.0)
    return stuck._replace(
        switch=stuck.switch._replace(bounce_s=ALWAYS_S, bounce_open_ratio=1.0 - strength)
    )


def _switch_sticking(machine: Machine, _strength: float) -> Machine:
    return _switch(machine, machine.switch.close_n, -1.0)


def _switch_bouncing(machine: Machine, strength: float) -> Machine:
    switch = machine.switch
    ratio = max(switch.bounce_open_ratio, 0.5)
    return machine._replace(switch=switch._replace(bounce_s=strength, bounce_open_ratio=ratio))


def _switch_stiff(machine: Machine, strength: float) -> Machine:
    ratio = machine.switch.open_n / machine.switch.close_n
    return _switch(machine, strength, ratio * strength)


def _switch_late(machine: Machine, strength: float) -> Machine:
    return machine._replace(switch=machine.switch._replace(latency_s=strength))


def _deeper(machine: Machine, more_mm: float) -> Machine:
    airway = machine.airway
    return machine._replace(airway=airway._replace(carina_mm=airway.carina_mm + more_mm))


def _carina_missed(machine: Machine, strength: float) -> Machine:
    return _deeper(machine, strength)


def _tube_displaced(machine: Machine, strength: float) -> Machine:
    return _deeper(machine, -strength)


def _tip_buckling(machine: Machine, strength: float) -> Machine:
    tip = machine.airway.tip._replace(buckling_n=strength, post_buckling_ratio=0.0)
    return machine._replace(airway=machine.airway._replace(tip=tip))


def _tip_detached(machine: Machine, strength: float) -> Machine:
    moved = machine.transmission
    shorter = machine._replace(transmission=moved._replace(offset_mm=moved.offset_mm - strength))
    return _switch(shorter, NEVER_N, NEVER_N)


def _narrowed(machine: Machine, gas_ratio: float, mucus_ratio: float) -> Machine:
    """A bore that lets through these shares of gas and of mucus."""
    line, airway = machine.line, machine.airway
    gas = line.bore_ml_per_s_per_root_mmhg * gas_ratio
    mucus = airway.uptake_ml_per_s_per_mmhg * mucus_ratio
    return machine._replace(
        line=line._replace(bore_ml_per_s_per_root_mmhg=gas),
        airway=airway._replace(uptake_ml_per_s_per_mmhg=mucus),
    )


def _rubbing(machine: Machine, force_n: float) -> Machine:
    """Friction in addition, as a force at the head."""
    axis = machine.insertion_axis
    more_v = machine.load_v_per_n * force_n
    return _insertion(machine, axis._replace(friction_v=axis.friction_v + more_v))


def _catheter_kinked(machine: Machine, strength: float) -> Machine:
    """Turbulent gas and creeping mucus through what is left of the bore; friction at the kink."""
    left = 1.0 - strength
    narrow = _narrowed(_rubbing(machine, strength * KINK_N), left**BLASIUS_POWER, left**4)
    moved = narrow.transmission
    stretch = moved.stretch_mm + strength * KINK_MM
    return narrow._replace(transmission=moved._replace(stretch_mm=stretch))


def _catheter_jammed(machine: Machine, strength: float) -> Machine:
    return _rubbing(machine, strength)


def _conduit_rerouted(machine: Machine, strength: float) -> Machine:
    moved = machine.transmission
    widths = bundle(width * strength for width in moved.widths_mm)
    return machine._replace(
        transmission=moved._replace(widths_mm=widths, stretch_mm=moved.stretch_mm * strength)
    )


def _motor_stalled(machine: Machine, _strength: float) -> Machine:
    return _insertion(machine, machine.insertion_axis._replace(friction_v=SEIZED_V))


def _motor_lost(machine: Machine, _strength: float) -> Machine:
    return _insertion(machine, machine.insertion_axis._replace(force_v=0.0))


def _motor_weak(machine: Machine, strength: float) -> Machine:
    axis = machine.insertion_axis
    return _insertion(machine, axis._replace(force_v=axis.force_v * (1.0 - strength)))


def _motor_reversed(machine: Machine, _strength: float) -> Machine:
    axis = machine.insertion_axis
    return _insertion(machine, axis._replace(polarity=-axis.polarity))


def _gear_lost(machine: Machine, _strength: float) -> Machine:
    """Neither does the head follow the motor, nor does the motor feel the head."""
    return machine._replace(gear_backlash_mm=PARTED_MM, load_v_per_n=0.0)


def _gear_worn(machine: Machine, strength: float) -> Machine:
    return machine._replace(gear_backlash_mm=machine.gear_backlash_mm + strength)


def _valve_stuck_open(machine: Machine, strength: float) -> Machine:
    return machine._replace(valve=machine.valve._replace(least_ratio=strength))


def _valve_stuck_closed(machine: Machine, strength: float) -> Machine:
    return machine._replace(valve=machine.valve._replace(most_ratio=strength))


def _valve_slow(machine: Machine, strength: float) -> Machine:
    """Drag in proportion to speed slows an axis down, and settles it sooner."""
    axis = machine.valve_axis
    left = 1.0 - strength
    return machine._replace(
        valve_axis=axis._replace(
            speed_per_v=axis.speed_per_v * left, time_constant_s=axis.time_constant_s * left
        )
    )


def _valve_jammed(machine: Machine, _strength: float) -> Machine:
    return machine._replace(valve_axis=machine.valve_axis._replace(friction_v=SEIZED_V))


def _valve_motor_lost(machine: Machine, _strength: float) -> Machine:
    return machine._replace(valve_axis=machine.valve_axis._replace(force_v=0.0))


def _valve_spring_broken(machine: Machine, _strength: float) -> Machine:
    broken = machine.valve._replace(spring_preload_v=0.0, spring_v_per_rad=0.0)
    return machine._replace(valve=broken)


def _pump(machine: Machine, ratio: float) -> Machine:
    line = machine.line
    return machine._replace(line=line._replace(pump_free_ml_per_s=line.pump_free_ml_per_s * ratio))


def _pump_runaway(machine: Machine, strength: float) -> Machine:
    line = _regulator_failed(machine, strength).line
    return machine._replace(line=line._replace(pump_runs_away=True))


def _pump_weak(machine: Machine, strength: float) -> Machine:
    return _pump(machine, 1.0 - strength)


def _pump_lost(machine: Machine, _strength: float) -> Machine:
    return _pump(machine, 0.0)


def _regulator_failed(machine: Machine, _strength: float) -> Machine:
    return machine._replace(line=machine.line._replace(regulator_ml_per_s_per_mmhg=0.0))


def _relief_failed(machine: Machine, _strength: float) -> Machine:
    return machine._replace(line=machine.line._replace(relief_ml_per_s_per_mmhg=0.0))


def _line_leak(machine: Machine, strength: float) -> Machine:
    line = machine.line
    leak = line.leak_ml_per_s_per_mmhg + strength
    return machine._replace(line=line._replace(leak_ml_per_s_per_mmhg=leak))


def _line_clogged(machine: Machine, strength: float) -> Machine:
    return _narrowed(machine, 1.0 - strength, 1.0 - strength)


def _canister_full(machine: Machine, strength: float) -> Machine:
    gas = max(1.0 - strength, GAS_LEFT)
    less = machine if gas > GAS_LEFT else _pump(machine, 0.0)
    return less._replace(line=less.line._replace(mmhg_per_ml=less.line.mmhg_per_ml / gas))


def _patient(machine: Machine, patient: Patient) -> Machine:
    return machine._replace(patient=patient)


EFFECTS: dict[Fault, Callable[[Machine, float], Machine]] = {
    Fault.SWITCH_STUCK_OPEN: _switch_stuck_open,
    Fault.SWITCH_STUCK_CLOSED: _switch_stuck_closed,
    Fault.SWITCH_BRIDGED: _switch_bridged,
    Fault.SWITCH_STICKING: _switch_sticking,
    Fault.SWITCH_BOUNCING: _switch_bouncing,
    Fault.SWITCH_STIFF: _switch_stiff,
    Fault.SWITCH_LATE: _switch_late,
    Fault.CARINA_MISSED: _carina_missed,
    Fault.TUBE_DISPLACED: _tube_displaced,
    Fault.TIP_BUCKLING: _tip_buckling,
    Fault.TIP_DETACHED: _tip_detached,
    Fault.CATHETER_KINKED: _catheter_kinked,
    Fault.CATHETER_JAMMED: _catheter_jammed,
    Fault.CONDUIT_REROUTED: _conduit_rerouted,
    Fault.MOTOR_STALLED: _motor_stalled,
    Fault.MOTOR_LOST: _motor_lost,
    Fault.MOTOR_WEAK: _motor_weak,
    Fault.MOTOR_REVERSED: _motor_reversed,
    Fault.GEAR_LOST: _gear_lost,
    Fault.GEAR_WORN: _gear_worn,
    Fault.VALVE_STUCK_OPEN: _valve_stuck_open,
    Fault.VALVE_STUCK_CLOSED: _valve_stuck_closed,
    Fault.VALVE_SLOW: _valve_slow,
    Fault.VALVE_JAMMED: _valve_jammed,
    Fault.VALVE_MOTOR_LOST: _valve_motor_lost,
    Fault.VALVE_SPRING_BROKEN: _valve_spring_broken,
    Fault.PUMP_RUNAWAY: _pump_runaway,
    Fault.PUMP_WEAK: _pump_weak,
    Fault.PUMP_LOST: _pump_lost,
    Fault.REGULATOR_FAILED: _regulator_failed,
    Fault.RELIEF_FAILED: _relief_failed,
    Fault.LINE_LEAK: _line_leak,
    Fault.LINE_CLOGGED: _line_clogged,
    Fault.CANISTER_FULL: _canister_full,
    Fault.CIRCUIT_DISCONNECTED: lambda machine, _: _patient(
        machine, patient_fault.disconnected(machine.patient)
    ),
    Fault.VENTILATOR_PRESSURE: lambda machine, ratio: _patient(
        machine, patient_fault.mispressured(machine.patient, ratio)
    ),
    Fault.DESATURATION: lambda machine, shunt: _patient(
        machine, patient_fault.desaturating(machine.patient, shunt)
    ),
    Fault.BRADYCARDIA: lambda machine, ratio: _patient(
        machine, patient_fault.vagal(machine.patient, ratio)
    ),
    Fault.LUNG_VOLUME_LOST: lambda machine, l_per_min: _patient(
        machine, patient_fault.flow_limited(machine.patient, l_per_min)
    ),
    Fault.MONITOR_LOST: lambda machine, _: _patient(
        machine, patient_fault.unlinked(machine.patient)
    ),
}
"""For every fault of `Means.MACHINE`."""


def check_strength(fault: Fault, strength: float) -> None:
    """Refuse a strength that the fault cannot have; raises InputError."""
    known = KINDS[fault].strength
    if known is None:
        if strength != 0.0:
            raise InputError(f"fault '{fault.title}' has no strength: leave '={strength:g}' out")
        return
    if not known.least <= strength <= known.most:
        unit = "" if known.unit == "1" else f" {known.unit}"
        raise InputError(
            f"fault '{fault.title}' has no strength {strength:g}{unit} ({known.meaning}): "
            f"{known.least:g} to {known.most:g}{unit}"
        )


def faulty(machine: Machine, fault: Fault, strength: float) -> Machine:
    """The same machine with a fault; nothing of a machine with other faults is undone.

    fault: one of `Means.MACHINE`. strength: see its row; 0 for a fault without one.
    Raises InputError for a strength out of range, KeyError for a fault of other means.
    """
    check_strength(fault, strength)
    if KINDS[fault].means != Means.MACHINE:
        raise KeyError(f"{fault.name} does not come by the machine's parameters")
    return EFFECTS[fault](machine, strength)
