"""A machine is not started with a limit that nothing can break."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller, record
from opensuction.controller.record import Settings
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import rig as rigs
from tests.safety.watchdog import changed

RIG = rigs.rig("bench", 1)
SETTINGS: Settings = rigs.assemble(
    RIG, PAPER, CompensationKind.PREVIEW, rigs.uncalibrated(RIG.profile), 1, by_contact=True
)[0].controller
PATHS = [path for path, _ in record._numbers(SETTINGS, "")]
ALONE = sorted({path for path in PATHS if PATHS.count(path) == 1})


def test_the_settings_of_a_machine_are_numbers() -> None:
    record.check(SETTINGS)
    assert len(PATHS) > 150
    assert "limits.in_airway_s" in ALONE
    assert "compensation.plays.weights" in PATHS  # of a plain tuple, under its name


@given(st.sampled_from(ALONE), st.sampled_from([math.nan, math.inf, -math.inf]))
def test_one_that_is_none_is_named(path: str, value: float) -> None:
    broken = changed(SETTINGS, {path: value})
    if math.isinf(value) and path in record.OPEN:
        record.check(broken)
        return
    with pytest.raises(InputError, match=f"settings.{path} is {value}: it must be a finite number"):
        record.check(broken)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_controller_is_not_started_with_it(value: float) -> None:
    broken = changed(SETTINGS, {"limits.in_airway_s": value})
    with pytest.raises(InputError, match=r"settings\.limits\.in_airway_s is"):
        controller.start(broken, 0.0, 0.0)
