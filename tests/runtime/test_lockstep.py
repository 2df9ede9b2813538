"""A machine in step: a controller that is kept from its work halts nothing."""

import os
import signal
import time

import pytest

from opensuction.kernel.vocabulary import CYCLE, Phase
from tests.runtime.machine_room import running, wait
from tests.runtime.room import INSIDE_MM

pytestmark = pytest.mark.real_time(machine_s=0.5)

STOPS = 5
"""Five times the patience of the drives each, while a machine in step has the tip inside."""


@pytest.mark.sweep
def test_a_cycle_goes_through_on_a_computer_that_stands_still_now_and_then() -> None:
    with running(in_step=True) as room:
        room.reach(lambda: room.truth("truth.tip_mm") > INSIDE_MM)
        assert room.control is not None
        for _ in range(STOPS):
            os.kill(room.control.pid, signal.SIGSTOP)
            time.sleep(0.1)
            assert room.phase() in CYCLE
            os.kill(room.control.pid, signal.SIGCONT)
            time.sleep(0.1)
        assert wait(lambda: room.phase() not in CYCLE)
        assert room.phase() == Phase.PARKED, room.state()
        assert room.now("loop.skipped") == 0.0
