"""Protocols by name: what a cycle shall do, before it is fitted to machine and patient.

Depths for the tip on this machine with this patient; the bench is a site without a patient.

Bounds of the pre-use test for a vacuum set point on a machine.
"""

from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le

from opensuction.kernel.vocabulary import AgeGroup, Meaning
from opensuction.procedure.cycle.check import (
    HOLD_S,
    LEAK_S,
    NEAR_MMHG,
    VACUUM_SETTLE_S,
    CheckItem,
    CheckPlan,
)

SENSOR_LIMIT_S = 0.5
"""Time in which sensors and contact must read soundly; assumed."""
HOMING_LIMIT_S = 2.0
"""Time in which the head of a cycle that has just ended must be home; assumed."""
JOG_LIMIT_S = 1.0
"""Time for each way of the jog; 2 mm at 200 mm/s2 take 0.2 s."""
STROKE_SHARE = 1.5
"""A stroke of the valve may last this many times its planned duration (and `STROKE_SETTLE_S`)."""
STROKE_SETTLE_S = 0.5
"""Time for the valve's servo to settle; assumed."""
VACUUM_READY_SHARE = 0.9
"""Share of the set point that the pump must reach; assumed."""
VACUUM_LIMIT_S = 4.0
"""Time for that; 18 L/min evacuate 0.8 L to 120 mmHg in 0.5 s [computed]."""
RELIEF_LIMIT_S = 1.5
"""Time to reach the relief valve; 0.3 s from a neonate's 80 mmHg [computed]."""
REGULATOR_LIMIT_S = 1.0
"""Time to come down from there; 0.1 s [computed]."""
BEYOND_MMHG = 25.0
"""Set point over the relief valve's; 219 mL/s through it take 4 [computed]."""
LOWERED_SHARE = 0.75
"""Lower set point, as share of the cycle's; assumed."""

LIMITS_S = {
    CheckItem.READINGS: SENSOR_LIMIT_S,
    CheckItem.CONTACT_OPEN: SENSOR_LIMIT_S,
    CheckItem.HEAD_HOME: HOMING_LIMIT_S,
    CheckItem.HEAD_ADVANCES: JOG_LIMIT_S,
    CheckItem.HEAD_RETURNS: JOG_LIMIT_S,
    CheckItem.LINE_VENTED: SENSOR_LIMIT_S,
    CheckItem.VACUUM_BUILDS: VACUUM_LIMIT_S,
    CheckItem.VACUUM_HOLDS: VACUUM_SETTLE_S + LEAK_S + HOLD_S,
    CheckItem.RELIEF_OPENS: RELIEF_LIMIT_S,
    CheckItem.REGULATOR_HOLDS: REGULATOR_LIMIT_S,
}
"""Longest time for each item, but for the strokes of the valve."""


def plan_check(vacuum_mmhg: float, relief_mmhg: float, jog_mm: float, stroke_s: float) -> CheckPlan:
    """The plan of the test.

    vacuum_mmhg: set point of the cycle. relief_mmhg: the mechanical relief valve's. jog_mm: head
    travel that does not move the parked tip. stroke_s: planned duration of a stroke of the valve.
    """
    stroke_limit_s = STROKE_SHARE * stroke_s + STROKE_SETTLE_S
    strokes_s = {CheckItem.VALVE_OPENS: stroke_limit_s, CheckItem.VALVE_CLOSES: stroke_limit_s}
    limits_s = {CheckItem.NONE: 0.0, **LIMITS_S, **strokes_s}
    return CheckPlan(
        jog_mm=jog_mm,
        ready_mmhg=VACUUM_READY_SHARE * vacuum_mmhg,
        set_mmhg=vacuum_mmhg,
        lowered_mmhg=LOWERED_SHARE * vacuum_mmhg,
        relief_mmhg=relief_mmhg,
        relieved_mmhg=relief_mmhg - min(NEAR_MMHG, 0.5 * (relief_mmhg - vacuum_mmhg)),
        beyond_mmhg=relief_mmhg + BEYOND_MMHG,
        limits_s=tuple(limits_s[item] for item in sorted(CheckItem)),
    )


class Site(NamedTuple):
    """Depths in mm, 0 at the lower end of the tube, positive towards the carina."""

    park_mm: Annotated[float, Ge(-250), Le(0)]
    """Tip when parked; behind the boundary, or on it on the bench."""
    boundary_mm: Annotated[float, Ge(-200), Le(0)]
    """Upper end of what counts as the patient: the tube's upper end, on the bench its lower."""
    fast_mm_per_s: Annotated[float, Gt(0), Le(60)]
    """Insertion speed inside the tube."""
    tube_mm: Annotated[float, Gt(0), Le(15)]
    """Inner diameter of the tube."""
    catheter_mm: Annotated[float, Gt(0), Le(8)]
    """Outer diameter of the catheter."""
    carina_mm: Annotated[float, Gt(0), Le(150)]
    """Where the carina is expected."""
    age: AgeGroup
    peep_cmh2o: Annotated[float, Ge(0), Le(25)]
    """PEEP that the ventilator is set to; airway pressure is judged against it."""
    monitored: bool
    """Whether a patient monitor belongs to the machine: then it must be heard."""
    breathes: bool
    """Whether the patient breathes on their own, besides the ventilator: that pulls the airway
    pressure down for as long as a breath lasts."""


BENCH_SITE = Site(
    park_mm=0.0,  # the tip starts and ends near 0 [design-speed]
    boundary_mm=0.0,
    fast_mm_per_s=9.0,  # the tip parks at the tube's end: nothing is fast
    tube_mm=8.5,
    catheter_mm=4.0,  # [paper] II-B
    carina_mm=100.0,
    age=AgeGroup.ADULT,
    peep_cmh2o=0.0,  # nobody breathes there
    monitored=False,
    breathes=False,
)
"""The paper's bench."""


NEARER_MM = 10.0
"""Approach by contact: by how much before its window a carina may be that has come nearer since it
was taught, head and neck having been moved; assumed."""


class Protocol(NamedTuple):
    """Protocol that a person sets; `PAPER_SOURCES` has the source of each value of a preset."""

    travel_mm: Annotated[
        float, Gt(0), Le(130), Meaning("tip travel from the tube's lower end to the stopping point")
    ]
    cap_mm: Annotated[
        float,
        Gt(0),
        Le(140),
        Meaning("deepest tip position ever allowed; at least 5 mm beyond the travel"),
    ]
    insertion_mm_per_s: Annotated[
        float, Gt(0), Le(30), Meaning("speed inwards beyond the tube's end")
    ]
    withdrawal_mm_per_s: Annotated[float, Gt(0), Le(60), Meaning("speed on the way out")]
    contact_from_mm: Annotated[
        float,
        Ge(0),
        Le(130),
        Meaning(
            "approach by contact: 10 mm before it, or where a back-off does not end it, it is a "
            "fault; `travel_mm` ends the search"
        ),
    ]
    backoff_mm: Annotated[
        float,
        Ge(0),
        Le(30),
        Meaning("approach by contact: distance from the carina at which suction takes place"),
    ]
    dwell_s: Annotated[
        float,
        Ge(0),
        Le(30),
        Meaning("from arrival to the start of withdrawal, valve stroke included"),
    ]
    nothing_comes_s: Annotated[
        float,
        Ge(0),
        Le(30),
        Meaning(
            "time without mucus that ends the dwell; at least as long as the gap of the way back "
            "takes; 0: the dwell lasts its whole time"
        ),
    ]
    vacuum_mmhg: Annotated[float, Ge(20), Le(150), Meaning("set point of the suction line")]
    negative_pressure_budget_s: Annotated[
        float,
        Gt(0),
        Le(60),
        Meaning("longest time from the valve's leaving its seat to its return"),
    ]
    in_airway_budget_s: Annotated[
        float, Gt(0), Le(60), Meaning("longest time of the tip in the patient")
    ]
    bench_only: Annotated[
        bool, Meaning("breaks a guideline's limit on purpose: never for a patient")
    ]


def nearest_contact_mm(protocol: Protocol) -> float:
    """Least depth at which a steady contact may be a carina that has come nearer.

    Drawing back tells it from a switch that is stuck: a tip that does not back off has no way to,
    and one that touches nearer than its back-off would suck inside the tube.
    """
    window_mm = protocol.contact_from_mm
    if protocol.backoff_mm == 0.0:
        return window_mm
    return min(window_mm, max(window_mm - NEARER_MM, protocol.backoff_mm))


PAPER = Protocol(
    travel_mm=90.0,
    cap_mm=95.0,
    insertion_mm_per_s=9.0,
    withdrawal_mm_per_s=9.0,
    contact_from_mm=30.0,
    backoff_mm=0.0,
    dwell_s=9.0,
    nothing_comes_s=0.0,
    vacuum_mmhg=120.0,
    negative_pressure_budget_s=24.0,
    in_airway_budget_s=35.0,
    bench_only=True,
)
"""The paper's cycle. Its 21 s of negative pressure exceed every guideline's 15 s."""

PAPER_SOURCES: dict[str, str] = {
    "travel_mm": "[paper] IV-B",
    "cap_mm": "[design] 5 mm beyond: the least margin the planner accepts",
    "insertion_mm_per_s": "[paper] IV-B",
    "withdrawal_mm_per_s": "[paper] IV-A: same velocity back",
    "contact_from_mm": "[design] the paper's shortest distance is 45",
    "backoff_mm": "[paper] suction where the tip stopped",
    "dwell_s": "[paper] Fig. 9",
    "nothing_comes_s": "[paper] the dwell has a fixed time",
    "vacuum_mmhg": "[paper] II-A: 80 to 120 for adults",
    "negative_pressure_budget_s": "[computed] 9 s dwell + 10 s withdrawal + 2 s stroke, and 3 s",
    "in_airway_budget_s": "[computed] 10 + 9 + 10 s, and 6 s",
    "bench_only": "guidelines ask for at most 15 s of negative pressure",
}
"""Where the paper's values come from."""

PROTOCOLS = {"paper": PAPER}
"""Protocols by name."""
