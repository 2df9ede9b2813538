"""A day in which something breaks: in which cycle it comes, and how the day goes on."""

from functools import cache

import numpy as np
import pytest

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.session.choice import CycleChoice, DayChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.day import day_fault, day_run, day_summary
from opensuction.session.day.day_run import Day, DayCycle
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant

HOURLY = DayChoice(repeat=3, every_min=60.0)
TWICE = DayChoice(repeat=2, every_min=60.0)


@cache
def played(*faults: str, asked: DayChoice = TWICE) -> tuple[Day, list[DayCycle]]:
    choice = CycleChoice(compensation="exact-inverse", faults=faults)
    resolved = resolution.resolve(choice)
    day_fault.check(asked, resolved)
    told: list[DayCycle] = []
    prepared = cycle_run.prepare(resolved)
    return day_run.play(prepared, asked, lambda done, *_: told.append(done)), told


@pytest.mark.parametrize(
    ("text", "cycle", "at"),
    [
        ("pump-lost", 1, AT_START),
        ("pump-lost@12.5", 1, FaultInstant(None, 12.5)),
        ("pump-lost@3612.5", 2, FaultInstant(None, 12.5)),
        ("pump-lost@1800", 2, AT_START),
        ("pump-lost@7379", 3, FaultInstant(None, 179.0)),
    ],
)
def test_an_instant_counts_from_the_start_of_the_day(
    text: str, cycle: int, at: FaultInstant
) -> None:
    found = day_fault.place(HOURLY, resolution.parse(text))
    assert (found.cycle, found.at) == (cycle, at)


def test_a_fault_after_the_last_cycle_is_refused() -> None:
    for text in ("pump-lost@7380", "pump-lost@20000"):
        with pytest.raises(InputError, match="the last of 3 cycles is over by then"):
            played(text, asked=HOURLY)


def test_what_never_comes_is_refused() -> None:
    with pytest.raises(InputError, match="no cycle of the day gets there"):
        played("pump-lost@suctioning+170")


def test_a_harmless_fault_changes_no_cycle() -> None:
    day, told = played("contact-glitch@3600")
    sound, _ = played()
    assert [cycle.number for cycle in told] == [1, 2]
    assert all(cycle.outcome.completed for cycle in day.cycles)
    (fault,) = day.faults
    assert (fault.cycle, fault.at_s, fault.noticed) == (2, 0.0, None)
    # Each cycle is followed for a second longer, in which a person might have reset the machine:
    # the catheter creeps on meanwhile.
    # So its sensors' noise is another one, and a phase may end some hundredths of a second later.
    for phase in set(sound.columns["phase"]) - {Phase.PARKED}:
        ticks = [int(np.count_nonzero(one.columns["phase"] == phase)) for one in (day, sound)]
        assert ticks[0] == pytest.approx(ticks[1], abs=100)
    for name, most in (("truth.tip_mm", 0.2), ("readings.head_mm", 0.1)):
        deepest = [float(one.columns[name].max()) for one in (day, sound)]
        assert deepest[0] == pytest.approx(deepest[1], abs=most)
    for one, other in zip(day.cycles, sound.cycles, strict=True):
        assert one.start_s == pytest.approx(other.start_s, abs=1e-9)
        assert one.outcome.removed_ml == pytest.approx(other.outcome.removed_ml, abs=0.05)


def test_what_breaks_stays_broken_and_a_person_resets_what_halts() -> None:
    day, _ = played("pump-lost@3614", asked=HOURLY)
    assert [cycle.outcome.completed for cycle in day.cycles] == [True, False, False]
    assert day.reset_cycles == (2, 3)
    (fault,) = day.faults
    assert (fault.instant, fault.cycle, fault.at_s) == ("@3614", 2, 14.0)
    assert fault.noticed is not None
    assert fault.noticed.cycle == 2
    assert fault.noticed.after_s > 0.0
    # The next cycle finds out before the catheter goes in.
    assert day.cycles[2].outcome.exposure.in_airway_s == 0.0
    assert any("halted in cycle 2, 3" in note for note in day_summary.notes(day))


def test_without_mains_the_day_is_over() -> None:
    day, _ = played("power-lost@suctioning+1")
    assert len(day.cycles) == 1
    assert any("ended with cycle 1 of 2" in note for note in day_summary.notes(day))


def test_a_controller_that_comes_back_goes_on_with_the_day() -> None:
    day, _ = played("controller-stopped@suctioning+1=3")
    assert [cycle.outcome.completed for cycle in day.cycles] == [False, True]
    assert day.reset_cycles == (1,)


def test_a_fault_may_be_noticed_cycles_after_it_came() -> None:
    """A relief valve that does not open is found by the next pre-use test."""
    day, _ = played("relief-failed@suctioning")
    (fault,) = day.faults
    assert fault.cycle == 1
    assert fault.noticed is not None
    assert fault.noticed.cycle == 2
    assert fault.noticed.name == "relief-opens"
    assert fault.noticed.after_s == pytest.approx(3600.0, abs=60.0)


def test_between_two_cycles_the_patient_has_the_fault() -> None:
    day, _ = played("desaturation@suctioning+3=0.6")
    idle = day.samples.time_s > 200.0
    assert np.max(day.samples.spo2_percent[idle]) < 80.0


def test_oxygen_comes_and_goes_in_a_day_with_a_fault_as_in_any() -> None:
    """The machine with its fault is the same; what the ventilator gives is not part of it."""
    day, _ = played("contact-glitch@3600")
    sound, _ = played()
    for found in (day, sound):
        assert [cycle.preoxygenation for cycle in found.cycles] == ["confirmed"] * 2
    seen, wanted = (found.samples.spo2_percent for found in (day, sound))
    assert np.median(seen) == pytest.approx(np.median(wanted), abs=0.1)
    assert [cycle.outcome.exposure.spo2_least_percent for cycle in day.cycles] == pytest.approx(
        [cycle.outcome.exposure.spo2_least_percent for cycle in sound.cycles], abs=0.1
    )
