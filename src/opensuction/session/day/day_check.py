"""Check of the choices for a day of cycles."""

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.errors import InputError
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.interlocks import LIFE_S
from opensuction.procedure.cycle.schedule import ScheduleMode
from opensuction.session.choice import DayChoice
from opensuction.session.cycle.resolution import ResolvedCycle
from opensuction.session.day import day_fault
from opensuction.simulation.injection import injection

MOST_CYCLES = 500
"""More would be weeks: a trial, not a day."""
MOST_INTERVAL_S = LIFE_S
"""[design] A catheter is changed by then: what begins later is another day."""


def check(day: DayChoice, resolved: ResolvedCycle) -> None:
    """Refuse what is no day of this cycle; raises InputError."""
    repeat, every_min = day.repeat, day.every_min
    if repeat > MOST_CYCLES:
        raise InputError(f"--repeat {repeat}: should be at most {MOST_CYCLES}")
    if every_min is not None and repeat < 2:
        raise InputError(f"--every {every_min:g} says nothing without --repeat 2 or more")
    if repeat > 1 and every_min is None:
        raise InputError(f"--repeat {repeat} needs --every MIN: minutes from start to start")
    if repeat > 1 and resolved.equipment.on_bench:
        raise InputError("--repeat is for a patient, and the bench has none: use another protocol")
    if every_min is not None:
        if day.every_s > MOST_INTERVAL_S:
            raise InputError(
                f"--every {every_min:g}: should be at most {MOST_INTERVAL_S / 60.0:g} min, the "
                "longest that a catheter is used"
            )
        schedule.schedule(ScheduleMode.TIMED, day.every_s)
    if repeat == 1:
        injection.check(resolved.faults)
    else:
        day_fault.place_all(day, resolved.faults)
    if day.self_calibrates:
        _check_learning(day, resolved)


def _check_learning(day: DayChoice, resolved: ResolvedCycle) -> None:
    """Refuse self-calibration where nothing could be learned or used; raises InputError."""
    if day.repeat < 2:
        raise InputError(
            "--self-calibrate is for the next cycle: add --repeat 2 or more, and --every MIN"
        )
    if resolved.compensation == CompensationKind.NONE:
        raise InputError(
            "--self-calibrate finds gap and offset, and compensation 'none' uses neither: use "
            "another, for example preview"
        )
    backoff_mm = resolved.protocol.backoff_mm
    if resolved.by_contact and backoff_mm <= 0.0:
        raise InputError(
            f"--self-calibrate needs a reversal at the carina, and backoff_mm is "
            f"{backoff_mm:g} mm: set it to 1 mm or more"
        )
