"""Detection of mucus on the twin's line, by a sensor with offset and noise."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from opensuction.controller.governor_limit import free_flow
from opensuction.controller.machine_profile import CLINICAL
from opensuction.procedure.suction import line_flow
from opensuction.procedure.suction.line_flow import NOTHING_SEEN, FlowSeen, FreeFlow
from opensuction.twin.machine import suction_line
from opensuction.twin.machine.suction_line import SuctionLine, SuctionState
from tests.settled import settled

DT_S = 0.001
MUCUS = 0.4
"""Share of the tip that mucus leaves."""
ADULT_MMHG, NEONATE_MMHG = 120.0, 80.0
LINE = SuctionLine(
    pump_free_ml_per_s=300.0,
    pump_occluded_mmhg=560.0,
    regulator_ml_per_s_per_mmhg=60.0,
    relief_mmhg=150.0,
    relief_ml_per_s_per_mmhg=60.0,
    mmhg_per_ml=760.0 / 800.0,
    bore_ml_per_s_per_root_mmhg=29.5,
    leak_ml_per_s_per_mmhg=0.02,
    pump_runs_away=False,
)
"""The twin's, with the catheter of an adult."""
THIN = LINE._replace(bore_ml_per_s_per_root_mmhg=4.0)
"""With a 6 Fr catheter."""


class Sensor(NamedTuple):
    """What a vacuum sensor adds to the truth."""

    noise_mmhg: float = 0.0
    offset_mmhg: float = 0.0


SENSORS = [
    Sensor(),
    Sensor(noise_mmhg=2.0),
    Sensor(noise_mmhg=2.0, offset_mmhg=7.0),
    Sensor(noise_mmhg=2.0, offset_mmhg=-7.0),
]


draw = settled(suction_line.step)
look = settled(line_flow.step)


def watch(
    flow: FreeFlow,
    line: SuctionLine,
    set_mmhg: float,
    shares: list[float],
    sensor: Sensor,
    every: int = 1,
) -> list[FlowSeen]:
    """What is seen in each tick of a second for each share of a free tip, from the set point on.

    On a thin line the pump rests from the set point down to nine tenths of it, by the truth.
    every: how many ticks of the line a tick of the controller lasts.
    """
    chance = np.random.default_rng(7)
    state = SuctionState(vacuum_mmhg=set_mmhg, gas_ml_per_s=0.0, gas_ml=0.0)
    seen, rests, found, ticks = NOTHING_SEEN, flow.at_rest, [], 0
    for share in shares:
        for noise in chance.normal(0.0, 1.0, round(1.0 / DT_S)):
            state = draw(line, state, not rests, set_mmhg, share, 0.0, DT_S)
            reading = state.vacuum_mmhg + sensor.offset_mmhg + sensor.noise_mmhg * float(noise)
            ticks += 1
            if ticks % every == 0:
                seen = look(flow, seen, reading, True, not rests, every * DT_S)
                found.append(seen)
            if flow.at_rest:
                rests = state.vacuum_mmhg >= (0.9 if rests else 1.0) * set_mmhg
    return found


def seconds(ticks: list[bool]) -> float:
    return sum(ticks) * DT_S


ADULT = free_flow(CLINICAL, 4.0, ADULT_MMHG, at_rest=False)
NEONATE = free_flow(CLINICAL, 2.0, NEONATE_MMHG, at_rest=True)
LINES = {"adult": (ADULT, LINE, ADULT_MMHG), "neonate": (NEONATE, THIN, NEONATE_MMHG)}


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("name", LINES)
def test_mucus_that_comes_is_never_taken_for_gas(name: str, sensor: Sensor) -> None:
    flow, line, set_mmhg = LINES[name]
    found = watch(flow, line, set_mmhg, [MUCUS] * 3, sensor)
    assert not any(line_flow.is_nothing_coming(seen, DT_S) for seen in found)
    assert seconds([line_flow.is_coming(seen, DT_S) for seen in found]) > 2.5


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("name", LINES)
def test_gas_alone_is_told_within_half_a_second_and_mucus_again(name: str, sensor: Sensor) -> None:
    flow, line, set_mmhg = LINES[name]
    found = watch(flow, line, set_mmhg, [MUCUS, 1.0, 1.0, MUCUS], sensor)
    told = [line_flow.is_nothing_coming(seen, DT_S) for seen in found]
    second = round(1.0 / DT_S)
    # The vacuum is on its way from one state to the other meanwhile.
    assert all(told[second + second // 2 : 3 * second])
    assert not any(told[3 * second + second // 2 :])


@pytest.mark.parametrize("every", [1, 2, 4])
def test_with_readings_further_apart_gas_alone_is_told_as_surely(every: int) -> None:
    """Half as many readings of a noisy sensor average out less: the window lasts longer for it."""
    found = watch(ADULT, LINE, ADULT_MMHG, [1.0] * 20, Sensor(noise_mmhg=2.0), every)
    told = [line_flow.is_nothing_coming(seen, every * DT_S) for seen in found]
    assert all(told[len(told) // 20 :])


def test_a_thin_catheter_tells_nothing_while_its_pump_runs() -> None:
    """The regulator lets in what nobody measures: it is not known, and so nothing is ended."""
    seen = NOTHING_SEEN
    for _ in range(2000):
        seen = line_flow.step(NEONATE, seen, NEONATE_MMHG, True, True, DT_S)
        assert not line_flow.is_known(seen, DT_S)


def test_what_was_seen_is_forgotten_and_an_invalid_reading_shows_nothing() -> None:
    seen = watch(ADULT, LINE, ADULT_MMHG, [1.0], Sensor())[-1]
    assert line_flow.is_nothing_coming(seen, DT_S)
    for _ in range(round((line_flow.STALE_S + 0.2) / DT_S)):
        seen = line_flow.step(ADULT, seen, math.nan, False, True, DT_S)
    assert not line_flow.is_known(seen, DT_S)
    assert not line_flow.is_nothing_coming(seen, DT_S)
    assert math.isfinite(seen.sum_mmhg)


def test_a_line_without_vacuum_is_not_judged() -> None:
    seen = NOTHING_SEEN
    for _ in range(1000):
        seen = line_flow.step(ADULT, seen, 5.0, True, True, DT_S)
    assert not line_flow.is_known(seen, DT_S)


@pytest.mark.parametrize(
    "changed",
    [
        {"pump_free_ml_per_s": 225.0},
        {"pump_occluded_mmhg": 400.0},
        {"mmhg_per_ml": 2.0 * LINE.mmhg_per_ml},
        {"bore_ml_per_s_per_root_mmhg": 34.0},
    ],
    ids=["weak pump", "pump of less vacuum", "canister half full", "wide bore"],
)
def test_on_a_line_that_is_not_as_the_profile_has_it_mucus_still_shows(
    changed: dict[str, Any],
) -> None:
    found = watch(ADULT, LINE._replace(**changed), ADULT_MMHG, [MUCUS] * 2, Sensor(2.0))
    assert not any(line_flow.is_nothing_coming(seen, DT_S) for seen in found)


def test_a_bore_that_is_narrower_than_known_ends_nothing() -> None:
    """A clogged or kinked catheter looks like one in which mucus is: the dwell lasts."""
    narrow = LINE._replace(bore_ml_per_s_per_root_mmhg=0.75 * LINE.bore_ml_per_s_per_root_mmhg)
    found = watch(ADULT, narrow, ADULT_MMHG, [1.0] * 2, Sensor(2.0))
    assert not any(line_flow.is_nothing_coming(seen, DT_S) for seen in found)
