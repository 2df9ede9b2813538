"""The twin in a loop of one's own is the one that a cycle plays, and takes commands alone."""

import math

import numpy as np
import pytest

import opensuction as osn


@pytest.fixture(scope="module")
def run() -> osn.Run:
    return osn.cycle(patient="neonate", seed=3, compensation="none")


def test_its_controller_drives_it_as_a_cycle_goes(run: osn.Run) -> None:
    twin = osn.Twin(patient="neonate", seed=3, compensation="none")
    controller = osn.Controller(twin.settings, catheter_age_s=0.0)
    requests = osn.NO_REQUESTS._replace(start=True, oxygen_skipped=True)
    tips_mm, phase = [], ""
    while phase != "parked":
        decision = controller.step(twin.readings, requests, 0.001)
        twin.step(decision.commands)
        requests, phase = osn.NO_REQUESTS, decision.phase
        tips_mm.append(twin.truth.tip_mm)
    # A row of a trace is of the moment before its tick.
    played = run.trace["truth.tip_mm"][1 : len(tips_mm) + 1]
    assert np.array_equal(tips_mm, played)
    assert np.ptp(tips_mm) > 30.0
    assert twin.time_s == pytest.approx(0.001 * len(tips_mm))


def test_without_commands_nothing_moves() -> None:
    twin = osn.Twin(machine="bench", compensation="none")
    at_rest = twin.readings
    for _ in range(200):
        twin.step(osn.IDLE)
    assert twin.truth.valve_open_ratio == 0.0
    assert twin.readings.head_mm == at_rest.head_mm
    assert repr(twin) == "Twin(0.200 s, head 0.0 mm, mouth clear)"


@pytest.mark.parametrize("name", ["head_mm", "insertion_v", "vacuum_mmhg"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_is_none_is_refused_and_nothing_passes(name: str, value: float) -> None:
    twin = osn.Twin(machine="bench", compensation="none")
    with pytest.raises(osn.InputError, match=f"commands.{name} is {value}: should be a finite"):
        twin.step(osn.IDLE._replace(**{name: value}))  # type: ignore[arg-type]
    assert twin.time_s == 0.0


def test_another_type_is_refused() -> None:
    twin = osn.Twin(machine="bench", compensation="none")
    with pytest.raises(osn.InputError, match="commands is tuple: should be Commands"):
        twin.step(tuple(osn.IDLE))  # type: ignore[arg-type]
    with pytest.raises(osn.InputError, match="none before the first step"):
        _ = twin.truth


def test_names_are_refused_as_for_a_cycle() -> None:
    with pytest.raises(osn.InputError, match="unknown patient 'nobody'"):
        osn.Twin(patient="nobody")
    with pytest.raises(osn.InputError, match="seed -1"):
        osn.Twin(seed=-1)
