"""Whether an identified transmission can be that of the machine it is to drive.

The governor's interval of where the tip can be rests on the identified model, so a file of another
machine, or of a recording with another zero, would move every limit along with the error.
"""

from opensuction.hysteresis.modified_dahl import ModifiedDahl, gap_mm
from opensuction.kernel.errors import InputError
from opensuction.settings.wording import one_line

GAP_RATIOS = (0.5, 1.5)
"""Gap over the machine's nominal one. Re-routing the conduit changes it by 30 % (DESIGN), another
catheter in it by as much again (assumed)."""

SLOPES = (0.85, 1.1)
"""mm of tip for each mm of head: the catheter neither shortens nor grows by more (assumed)."""

MOST_SHIFT_MM = 10.0
"""Tip between both ways, half way in, off the nominal one; a larger shift is another zero
(assumed)."""

HALF_WAY_MM = 50.0
"""Head position at which the shift is taken: half of the paper's excitation."""


def check(model: ModifiedDahl, nominal: ModifiedDahl, where: object) -> None:
    """Refuse a model that cannot be this machine's; raises InputError.

    nominal: the machine's transmission as it was built. where: names the source in messages.
    """
    ratio = float(gap_mm(model)) / float(gap_mm(nominal))
    shift_mm = _middle_mm(model) - _middle_mm(nominal)
    problem = ""
    if not GAP_RATIOS[0] <= ratio <= GAP_RATIOS[1]:
        least, most = (bound * float(gap_mm(nominal)) for bound in GAP_RATIOS)
        problem = (
            f"the gap 2 velocity_gain/decay is {float(gap_mm(model)):.1f} mm, should be from "
            f"{least:.1f} to {most:.1f} mm"
        )
    elif not SLOPES[0] <= model.slope <= SLOPES[1]:
        problem = (
            f"parameters.slope is {model.slope:.4g}, should be from {SLOPES[0]} to {SLOPES[1]}"
        )
    elif not abs(shift_mm) <= MOST_SHIFT_MM:
        problem = (
            f"with the head at {HALF_WAY_MM:g} mm the tip would be at {_middle_mm(model):.1f} mm, "
            f"should be within {MOST_SHIFT_MM:g} mm of {_middle_mm(nominal):.1f} mm (the zero of "
            "the recording may be another)"
        )
    if problem:
        raise InputError(
            one_line(f"{where}: {problem} for this machine; identify the machine itself")
        )


def _middle_mm(model: ModifiedDahl) -> float:
    """Tip between the way in and the way out, half way in."""
    return model.slope * HALF_WAY_MM + model.offset_mm
