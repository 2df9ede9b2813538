"""Cost of the alarms in a tick, with nothing wrong and with alarms sounding."""

import numpy as np
import numpy.typing as npt
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Tell
from benchmarks.timing import best_s
from opensuction.kernel.compiled import compiled
from opensuction.safety.alarm import alarm, alarm_state
from opensuction.safety.alarm.alarm_state import RELEASED, AlarmSettings, AlarmState
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import encode

SETTINGS = alarm_state.check_settings(pause_s=120.0, reminder_s=60.0)
TICKS = 200_000
WRONG = {
    "nothing": set[Condition](),
    "one": {Condition.SPO2_LOW},
    "three": {Condition.SPO2_LOW, Condition.AUTOMATION_STOPPED, Condition.HEAD_STALLED},
}


@compiled
def _run(settings: AlarmSettings, state: AlarmState, conditions: npt.NDArray[np.int64]) -> int:
    """Ticks with these conditions; the sum keeps the compiler from dropping them."""
    total = 0
    for holding in conditions:
        state, signals = alarm.step(settings, state, holding, False, RELEASED, 0.001)
        total += signals.first + signals.audible
    return total


@pytest.mark.parametrize("wrong", WRONG)
def test_alarm_tick(benchmark: BenchmarkFixture, tell: Tell, wrong: str) -> None:
    conditions = np.full(TICKS, encode(WRONG[wrong]), dtype=np.int64)
    shortest_s = best_s(benchmark, lambda: _run(SETTINGS, alarm_state.START, conditions), rounds=15)
    tick_ns = shortest_s / TICKS * 1e9
    benchmark.extra_info["ns_per_tick"] = tick_ns
    tell(f"alarms, {wrong} wrong: {tick_ns:.0f} ns a tick")
