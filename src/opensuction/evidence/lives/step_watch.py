"""Watch over the steps of the processes of a life: who works, and who stands still.

A supervisor ends a process that hangs, in time, and no other. Whether one hung or worked is seen
by its steps alone.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from opensuction.evidence.lives.simulated_computer import Step
from opensuction.host.host import NS_PER_S

STEADY_S = 0.2
"""One that does nothing for longer stands still."""
HANGS_S = {"control_process": 1.0, "recorder_process": 3.0}
"""One of these that stands still for longer hangs."""
WORKS_S = 0.5
"""One that has been at work for so long has given a sign of life since it stood still."""
LATE_S = 0.5
"""After that time it has been ended."""
SUPERVISOR, RECORDER = "supervisor", "recorder_process"
UNSYNCED_S = 2.0
"""What was published for longer is on the disk, where recorder and disk have worked."""
SOUND_S = 3.0
"""They have, without a disturbance for so long."""


class _Steady(NamedTuple):
    """Steps of one process without a standstill."""

    pid: int
    since_ns: int
    last_ns: int


class StepWatch:
    """Follows the steps of all processes, by the names of their modules."""

    def __init__(
        self,
        now_ns: int,
        tell: Callable[[str], None],
        may_keep: Callable[[], bool] = lambda: True,
    ) -> None:
        """tell: hears of what must not be. may_keep: true while disk and database take all."""
        self._tell, self._may_keep = tell, may_keep
        self._steady: dict[str, _Steady] = {}
        self._recorded_ns = now_ns
        self.away_ns = 0
        """Longest time in which no recorder did anything that could be kept."""
        self.is_over = False
        """All are told to end: nobody is supervised any more."""

    def see(self, step: Step) -> None:
        """Take a step that is done now."""
        name = step.module.rpartition(".")[2]
        known = self._steady.get(name)
        if name == RECORDER and self._may_keep():
            self.away_ns = max(self.away_ns, step.at_ns - self._recorded_ns)
            self._recorded_ns = step.at_ns
        if known is None or known.pid != step.pid:
            self._steady[name] = _Steady(step.pid, step.at_ns, step.at_ns)
            return
        since_ns = known.since_ns
        if step.at_ns - known.last_ns > STEADY_S * NS_PER_S:
            self._judge_silence(name, step.at_ns)
            since_ns = step.at_ns
        self._steady[name] = _Steady(step.pid, since_ns, step.at_ns)

    def is_steady(self, module: str, from_ns: int, now_ns: int) -> bool:
        """True where a process has been at work from an instant until now."""
        known = self._steady.get(module.rpartition(".")[2])
        if known is None or now_ns - known.last_ns > STEADY_S * NS_PER_S:
            return False
        return known.since_ns <= from_ns

    def find_unkept(self, now_ns: int, unsound_ns: int) -> tuple[float, float]:
        """Time, by the computer's clock in s, of which a loss of power now may take anything along.

        unsound_ns: until when disk or processors have been disturbed.
        """
        from_ns = now_ns - round(SOUND_S * NS_PER_S)
        is_kept = self.is_steady(RECORDER, from_ns, now_ns) and unsound_ns < from_ns
        now_s = now_ns / NS_PER_S
        return (now_s - UNSYNCED_S if is_kept else -math.inf), now_s

    def hear_killed(self, name: str, now_ns: int) -> None:
        """A process was killed by no fault of the life."""
        if name not in HANGS_S or name not in self._steady:
            return
        worked_s = (now_ns - self._steady[name].since_ns) / NS_PER_S
        if worked_s > WORKS_S and self.is_steady(name, self._steady[name].since_ns, now_ns):
            self._tell(f"the {name} is ended, which has been at work for {worked_s:.1f} s")
        self._judge_silence(name, now_ns)

    def _judge_silence(self, name: str, now_ns: int) -> None:
        """Tell where a process has hung too long beside a supervisor that was at work."""
        if name not in HANGS_S or self.is_over:
            return
        silent_s = (now_ns - self._steady[name].last_ns) / NS_PER_S
        watched = self.is_steady(SUPERVISOR, self._steady[name].last_ns, now_ns)
        if watched and silent_s > HANGS_S[name] + LATE_S:
            self._tell(f"the {name} does nothing for {silent_s:.1f} s, and nobody ends it")
