"""Protocols by name: what a cycle shall do, before it is fitted to machine and patient."""

from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le

from opensuction.kernel.meaning import Meaning

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
