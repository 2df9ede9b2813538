"""Depths for the tip on this machine with this patient; the bench is a site without a patient."""

from typing import Annotated, NamedTuple

from annotated_types import Ge, Gt, Le

from opensuction.kernel.age_group import AgeGroup


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
