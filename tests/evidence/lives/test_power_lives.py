"""Lives in which the computer loses its power: what outlives it, and mistakes that they find."""

from collections.abc import Callable

import pytest

from opensuction.evidence.lives import life
from opensuction.evidence.lives.life_fault import ALL, RECORDER, Kind, LifeFault
from opensuction.evidence.lives.life_record import Life
from opensuction.kernel.vocabulary import Phase
from opensuction.runtime import nonvolatile_memory
from opensuction.runtime.database_writer import DatabaseWriter
from opensuction.runtime.nonvolatile_memory import NonvolatileMemory
from tests.evidence.lives.chosen_life import broken, play

ON_THE_WAY_IN = LifeFault(Kind.POWER, "", Phase.INSERTING, 2.0, 3.0)
ON_THE_WAY_OUT = LifeFault(Kind.POWER, "", Phase.WITHDRAWING, 1.0, 0.05)
EARLY = LifeFault(Kind.POWER, "", Phase.PRELOADING, 0.05, 1.0)
AT_THE_BEGIN = LifeFault(Kind.POWER, "", Phase.INSERTING, 0.001, 1.0)
"""The recorder has not seen yet that the head moves."""
AT_REST = LifeFault(Kind.POWER, "", None, 2.25, 2.0)
"""Before the cycle, in the .2 s that the machine is parked."""
SET_BACK = LifeFault(Kind.WALL_CLOCK, "", Phase.CHECKING, 0.0, -90_000.0)
SET_BACK_AT_REST = LifeFault(Kind.WALL_CLOCK, "", None, 2.248, -90_000.0)


@pytest.mark.parametrize(
    "faults",
    [
        pytest.param((ON_THE_WAY_IN,), id="on the way in"),
        pytest.param((ON_THE_WAY_OUT,), id="on the way out", marks=pytest.mark.sweep),
        pytest.param((EARLY,), id="before the way in", marks=pytest.mark.sweep),
        pytest.param((AT_THE_BEGIN,), id="as it begins", marks=pytest.mark.sweep),
        pytest.param((AT_REST,), id="at rest", marks=pytest.mark.sweep),
        pytest.param((SET_BACK, ON_THE_WAY_IN), id="clock set back", marks=pytest.mark.sweep),
        pytest.param((ON_THE_WAY_IN, EARLY._replace(phase=None, after_s=18.0)), id="twice"),
    ],
)
def test_a_loss_of_power_brings_the_catheter_out_and_resets_no_limit(
    faults: tuple[LifeFault, ...],
) -> None:
    found = play(*faults)
    assert found.violations == ()
    course = [one.what for one in found.events]
    fault = next(one for one in faults if one.kind is Kind.POWER)
    after = course[course.index(f"fault {fault.title}") :]
    if fault.phase is not None:
        assert "people are told: watchdog-fired" in after
    assert {"phase parked", "phase halted"} & set(after)


def test_a_disk_that_was_slow_once_is_asked_to_keep_a_recording_soon_again() -> None:
    """Ten seconds before the power goes; a sync had taken two seconds then."""
    faults = (
        LifeFault(Kind.DISK_SLOW, "", Phase.CHECKING, 0.058991217020704236, 1.0664744366259244),
        LifeFault(Kind.KILL, RECORDER, Phase.CHECKING, 0.05982196079344959, 0.0),
        LifeFault(Kind.POWER, "", Phase.CLOSING, 0.06486292049895756, 4.0630505816299305),
    )
    assert life.play(Life(1002351, 45, faults)).violations == ()


def test_a_catheter_ages_while_no_controller_runs() -> None:
    """All died, and the power goes soon after the next controller has begun."""
    faults = (
        LifeFault(Kind.KILL, ALL, None, 13.647363188401465, 0.0),
        LifeFault(Kind.POWER, "", None, 23.140061747794235, 0.5076790283365507),
    )
    assert life.play(Life(255396292, 31, faults)).violations == ()


def test_a_person_who_saw_nothing_of_a_cycle_starts_one_after_the_rest_of_a_pass() -> None:
    """Power went in CHECKING, while the nurse's own processor stood still: a pass may have been
    made, so the patient rests for three minutes first.
    """
    faults = (
        LifeFault(Kind.POWER, "", None, 4.096870766103436, 0.005249572365389113),
        LifeFault(Kind.STANDSTILL, "", Phase.CHECKING, 0.04575727590464998, 7.60060341971531),
    )
    found = life.play(Life(147919444, 21, faults))
    assert found.violations == ()
    begun_s = [one.at_s for one in found.events if one.what == "phase checking"]
    assert len(begun_s) == 2
    assert begun_s[1] - begun_s[0] > 180.0


def test_a_catheter_of_unknown_age_is_changed_before_a_cycle() -> None:
    found = play(SET_BACK_AT_REST, AT_REST)
    assert found.violations == ()
    course = [one.what for one in found.events]
    assert course.index("phase out-of-service") < course.index("phase inserting")


def _nothing(*_: object) -> None:
    return None


@pytest.mark.parametrize(
    ("owner", "name", "faults", "invariant"),
    [
        pytest.param(nonvolatile_memory, "recall", (ON_THE_WAY_IN,), "memory", id="forgets"),
        pytest.param(NonvolatileMemory, "take", (ON_THE_WAY_OUT,), "memory", id="notes nothing"),
        pytest.param(DatabaseWriter, "sync", (ON_THE_WAY_OUT,), "rows", id="syncs nothing"),
    ],
)
def test_a_mistake_is_found(
    owner: object,
    name: str,
    faults: tuple[LifeFault, ...],
    invariant: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(owner, name, _nothing)
    assert invariant in broken(play(*faults))


def test_a_copy_that_is_written_late_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a cycle ends and not as it begins."""
    take: Callable[..., None] = NonvolatileMemory.take
    phase = nonvolatile_memory._PHASE

    def take_at_rest(memory: NonvolatileMemory, row: "list[float]", rule: object) -> None:
        if row[phase] == Phase.PARKED:
            take(memory, row, rule)

    monkeypatch.setattr(NonvolatileMemory, "take", take_at_rest)
    assert "memory" in broken(play(AT_THE_BEGIN))
