"""One-line description of a planned cycle, of the protocol in force or of a draft."""

import math


def say(
    deepest_mm: float, back_mm: float, vacuum_mmhg: float, suction_s: float, by_contact: bool
) -> str:
    """The line. back_mm: where suction takes place by contact; infinite where it has touched.

    >>> say(48.47, 48.47, 120.0, 14.96, by_contact=False)
    'to 48.5 mm, 120 mmHg, at most 15 s suction'
    >>> say(95.0, 88.0, 120.0, 15.0, by_contact=True)
    'until the carina is touched, 95 mm at most, then back to 88 mm, 120 mmHg, at most 15 s suction'
    """
    where = f"to {_mm(deepest_mm)}"
    if by_contact:
        back = "" if math.isinf(back_mm) else f", then back to {_mm(back_mm)}"
        where = f"until the carina is touched, {_mm(deepest_mm)} at most{back}"
    # Rounded up: it is a promise.
    most_s = math.ceil(10.0 * suction_s - 1e-9) / 10.0
    return f"{where}, {vacuum_mmhg:.0f} mmHg, at most {most_s:g} s suction"


def _mm(depth_mm: float) -> str:
    return f"{round(depth_mm, 1):g} mm"
