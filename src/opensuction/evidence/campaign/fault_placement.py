"""Instant and strength of a fault, by shares of a span of the sound cycle and of its own range."""

import math

from opensuction.evidence.campaign.healthy_cycle import AIRWAY, HealthyCycle
from opensuction.kernel.phase import Phase
from opensuction.simulation.injection.fault_instant import FaultInstant
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import ROWS

EDGE_S = 0.002
"""How far from an edge of a span an instant at this edge lies: within it, and not on it."""


def find_time_s(cycle: HealthyCycle, span: str, share: float) -> float:
    """The instant at a share of a span, 0 to 1, in whole ticks from the start."""
    first_s, last_s = cycle.spans[span]
    return round(first_s + EDGE_S + share * max(last_s - first_s - 2.0 * EDGE_S, 0.0), 3)


def find_instant(cycle: HealthyCycle, span: str, share: float) -> FaultInstant:
    """As `find_time_s`, written as the command line does: from the begin of its phase."""
    at_s = find_time_s(cycle, span, share)
    phases = {name: one for name, one in cycle.spans.items() if name != AIRWAY}
    name = max(
        (name for name, (begin_s, _) in phases.items() if begin_s <= at_s),
        key=lambda name: phases[name][0],
    )
    if name == Phase.PARKED.name.lower():
        return FaultInstant(None, at_s)
    return FaultInstant(Phase[name.upper()], round(at_s - phases[name][0], 3))


def find_strength(fault: Fault, share: float) -> float:
    """Anywhere in the fault's range; by ratio where it spans more than a factor of ten."""
    strength = ROWS[fault].strength
    if strength is None:
        return 0.0
    if strength.least > 0.0 and strength.most > 10.0 * strength.least:
        ratio = math.log(strength.most / strength.least)
        return min(strength.least * math.exp(share * ratio), strength.most)
    return min(strength.least + share * (strength.most - strength.least), strength.most)
