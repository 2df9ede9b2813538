"""Assumptions of the proofs on settings hold for those that a controller starts with."""

import math
from typing import Any

import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller
from opensuction.controller import record as record_module
from opensuction.controller.record import Settings
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Setpoints
from opensuction.kernel.record import make_zero
from opensuction.procedure.planning.protocol import PAPER
from opensuction.safety.governor import limiter
from opensuction.safety.watch.watch_state import Watch
from opensuction.simulation import rig as rigs
from tests.controller import bedside
from tests.proof.span import KEPT_SIZES, SETTINGS
from tests.safety.watchdog import changed


def bench() -> Settings:
    chosen = rigs.rig("bench", 1)
    calibration = rigs.uncalibrated(chosen.profile)
    loop, _ = rigs.assemble(
        chosen, PAPER, CompensationKind.PREVIEW, calibration, 1, by_contact=True
    )
    settings: Settings = loop.controller
    return settings


BENCH = bench()
SHIPPED = {"bench": BENCH} | {
    patient: bedside.at_bed(patient)[0].controller for patient in bedside.PROTOCOLS
}


def numbers(record: Any, path: str) -> list[tuple[str, float]]:
    return list(record_module._numbers(record, path))


def bounds_of(path: str) -> tuple[float, float]:
    for ending, bounds in SETTINGS.items():
        if path.endswith("." + ending):
            return bounds if isinstance(bounds, tuple) else (-bounds, bounds)
    return -1e6, 1e6


@pytest.mark.parametrize("name", SHIPPED)
def test_a_machine_is_within_what_the_proofs_ask_of_settings(name: str) -> None:
    settings = SHIPPED[name]
    record_module.check(settings)
    parts = ("limits", "insertion_servo", "valve_servo", "valve_motion")
    for part in parts:
        for path, value in numbers(getattr(settings, part), f"settings.{part}"):
            low, high = bounds_of(path)
            assert low <= value <= high or path.removeprefix("settings.") in record_module.OPEN
    for servo in (settings.insertion_servo, settings.valve_servo):
        assert servo.friction_v >= -servo.voltage_limit_v


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("head_mm", [0.0, 40.0, -1e6, 1e6, math.nan, math.inf])
def test_a_controller_starts_within_what_the_proofs_ask(name: str, head_mm: float) -> None:
    core = controller.start(SHIPPED[name], head_mm, 0.0).core
    sizes = {f".{name}": size for name, size in KEPT_SIZES.items() if isinstance(size, float)}
    held = [
        (path, value, size)
        for path, value in numbers(core, "core")
        for ending, size in sizes.items()
        if f".{path}".endswith(ending)
    ]
    assert len(held) > 15
    assert [path for path, value, size in held if not abs(value) <= size] == []


SIGNED = (*record_module.POSITIVE, *record_module.NOT_NEGATIVE)


@pytest.mark.parametrize("path", SIGNED)
def test_a_setting_of_the_wrong_sign_is_refused(path: str) -> None:
    with pytest.raises(InputError, match=rf"settings\.{path} is -1.0: it must"):
        record_module.check(changed(BENCH, {path: -1.0}))


@pytest.mark.parametrize("path", record_module.POSITIVE)
def test_a_setting_that_is_divided_by_is_not_0(path: str) -> None:
    with pytest.raises(InputError, match=rf"settings\.{path} is 0.0: it must be above 0"):
        record_module.check(changed(BENCH, {path: 0.0}))


def test_the_limiter_would_push_with_a_negative_gain_of_speed() -> None:
    """The counterexample that N5 had without it, in the function that runs."""
    limits = changed(BENCH, {"limits.head_mm_per_s2": -1000.0}).limits
    last = make_zero(Setpoints, head_mm=10.0, head_mm_per_s=5.0, insertion_on=True)
    seen = make_zero(Watch, head_mm=10.0)
    proposal = last._replace(head_mm=10.0)
    allowed, _ = limiter.narrow(limits, last, seen, proposal, 0, 0.001)
    assert allowed.head_mm > proposal.head_mm
    sound, _ = limiter.narrow(BENCH.limits, last, seen, proposal, 0, 0.001)
    assert sound.head_mm == proposal.head_mm
