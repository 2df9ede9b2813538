"""Faults of pump, regulator, canister, suction line and vacuum sensor."""

from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import (
    MachineEffect,
    ReadingEffect,
    Strength,
    drifting,
    frozen_reading,
    glitch,
    in_machine,
    invalid_reading,
    row,
    share,
)
from opensuction.twin.fault.reading_fault import Channel, Mode
from opensuction.twin.machine.machine import Machine
from opensuction.twin.machine.suction_line import SuctionLine

GAS_LEFT = 0.05
"""[assumed] Share of the canister's volume that is gas when its float has shut."""


def narrow_bore(machine: Machine, gas_ratio: float, mucus_ratio: float) -> Machine:
    """The same machine with a bore that lets through these shares of gas and of mucus."""
    line, airway = machine.line, machine.airway
    gas = line.bore_ml_per_s_per_root_mmhg * gas_ratio
    mucus = airway.uptake_ml_per_s_per_mmhg * mucus_ratio
    return machine._replace(
        line=line._replace(bore_ml_per_s_per_root_mmhg=gas),
        airway=airway._replace(uptake_ml_per_s_per_mmhg=mucus),
    )


def _weaken_pump(line: SuctionLine, lost: float) -> SuctionLine:
    return line._replace(pump_free_ml_per_s=line.pump_free_ml_per_s * (1.0 - lost))


def _leak(line: SuctionLine, more: float) -> SuctionLine:
    return line._replace(leak_ml_per_s_per_mmhg=line.leak_ml_per_s_per_mmhg + more)


def _fill_canister(line: SuctionLine, full: float) -> SuctionLine:
    gas = max(1.0 - full, GAS_LEFT)
    less = line if gas > GAS_LEFT else _weaken_pump(line, 1.0)
    return less._replace(mmhg_per_ml=less.mmhg_per_ml / gas)


ROWS = {
    Fault.PUMP_RUNAWAY: row(
        "the pump runs whatever it is told, and the regulator is shut",
        in_machine(
            "line",
            lambda line, _: line._replace(pump_runs_away=True, regulator_ml_per_s_per_mmhg=0.0),
        ),
        detected_by="line vacuum",
    ),
    Fault.PUMP_WEAK: row(
        "the pump moves less gas than it should",
        in_machine("line", _weaken_pump),
        share("share of its flow that is lost", 0.7, 0.05, 0.99),
        detected_by="vacuum signature, pre-use test",
    ),
    Fault.PUMP_LOST: row(
        "the pump stands still",
        in_machine("line", lambda line, _: _weaken_pump(line, 1.0)),
        detected_by="vacuum signature, pre-use test",
    ),
    Fault.REGULATOR_FAILED: row(
        "the regulator lets no air in: vacuum rises to the relief valve, and does not vent",
        in_machine("line", lambda line, _: line._replace(regulator_ml_per_s_per_mmhg=0.0)),
        detected_by="line vacuum, pre-use test",
    ),
    Fault.RELIEF_FAILED: row(
        "the relief valve does not open",
        in_machine("line", lambda line, _: line._replace(relief_ml_per_s_per_mmhg=0.0)),
        detected_by="pre-use test; alone it does no harm",
    ),
    Fault.LINE_LEAK: row(
        "air leaks into line or canister",
        in_machine("line", _leak),
        Strength("leak in addition", "mL/s/mmHg", 0.02, 50.0, 2.0),
        detected_by="vacuum signature, pre-use test",
    ),
    Fault.LINE_CLOGGED: row(
        "the catheter's bore is clogged",
        MachineEffect(lambda machine, lost: narrow_bore(machine, 1.0 - lost, 1.0 - lost)),
        share("share of its conductance that is lost", 0.95, 0.1),
        detected_by="vacuum signature",
    ),
    Fault.CANISTER_FULL: row(
        "the canister fills up: it holds less gas, and its float shuts the pump off when full",
        in_machine("line", _fill_canister),
        share("share of its volume that is full; the float shuts from 0.95 on", 1.0, 0.1),
        detected_by="vacuum signature, pre-use test",
    ),
    Fault.VACUUM_SENSOR_FROZEN: frozen_reading(
        Channel.VACUUM, "the vacuum sensor's value", "signature"
    ),
    Fault.VACUUM_SENSOR_OFFSET: row(
        "the vacuum sensor is off by a constant",
        ReadingEffect(Channel.VACUUM, Mode.OFFSET),
        Strength("reading less truth", "mmHg", -200.0, 200.0, -50.0),
        detected_by="pre-use test: a vented line",
    ),
    Fault.VACUUM_SENSOR_NOISY: row(
        "the vacuum sensor's value is noisy",
        ReadingEffect(Channel.VACUUM, Mode.NOISY),
        Strength("standard deviation", "mmHg", 0.5, 100.0, 20.0),
        detected_by="pre-use test",
    ),
    Fault.VACUUM_SENSOR_INVALID: invalid_reading(Channel.VACUUM, "the vacuum sensor"),
    Fault.VACUUM_GLITCH: glitch(
        Channel.VACUUM,
        "the vacuum sensor's value",
        Strength("reading less truth", "mmHg", -200.0, 200.0, 50.0),
    ),
    Fault.VACUUM_SENSOR_DRIFTING: drifting(
        Channel.VACUUM,
        "the vacuum sensor's value",
        Strength("reading less truth, for each second", "mmHg/s", -20.0, 20.0, 2.0),
        "pre-use test: a vented line; vacuum signature",
    ),
}
