"""Deaths of processes in the middle of cycles, and what is so afterwards: judged by the oracle.

The twin survives all of it. Where the tip is, and whether somebody was told at the bedside, is its
truth; what the dead had to say is looked for on disk and on record.
"""

import math
import signal
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from opensuction.host.host import Child, after
from opensuction.ipc.liveness import Heartbeat, Process
from opensuction.kernel.vocabulary import CYCLE, RESTING, Phase
from opensuction.machine import port
from opensuction.machine.twin.live_judge import LiveJudge
from opensuction.records.history import PastCycle
from opensuction.records.records import Records
from opensuction.runtime import launch
from opensuction.runtime.machine_folder import CONTROLS, RECORDS, SUPERVISES
from opensuction.runtime.supervisor import CONTROL_HUNG_S, HUNG_S, TRIES, TRIES_S
from tests.runtime.fate import (
    SEEN,
    TOLD_WITHIN_S,
    Fate,
    Kept,
    first_alone_s,
    first_told_s,
    last_inside_s,
    list_late_drives,
    look_at_records,
    shows,
)
from tests.runtime.identity import ABOUT
from tests.runtime.room import Room

VICTIMS = {
    "control": (CONTROLS,),
    "recorder": (RECORDS,),
    "supervisor": (SUPERVISES,),
    "all": (SUPERVISES, RECORDS, CONTROLS),
}
LOCKS = {"control": CONTROLS, "recorder": RECORDS}
"""Of what may hang, besides, at the moment of a death."""
BOUNDS_S = {"control": CONTROL_HUNG_S, "recorder": HUNG_S}
"""Without a sign of life for so long it is replaced."""
REPLACED_S = 5.0
"""So long after its bound another one is there: it is started, and loads its machine code."""
OUT_WITHIN_S = 12.0
"""From the death of the controller to the tip out of the tube: the drives draw it out at once, with
suction still on or not, at the speed of a withdrawal."""
CYCLE_WITHIN_S = 40.0
"""Where the controller lives, the cycle ends as it would have."""
LOOK_S, RECORD_LOOK_S, FOLLOWS_S = 0.05, 0.5, 0.5
ON_RECORD_WITHIN_S = 60.0


SUCTIONS_S = 7.5
"""After the start's button the tip is at its depth, and suction is on."""


class Death(NamedTuple):
    """Who dies when, and who hangs from then on."""

    victim: str
    at_s: float
    """After the start's button."""
    hung: str | None


AT_ITS_BEGINNING = (Death("all", 0.0, None), Death("supervisor", 0.0, "recorder"))
"""The recorder has read nothing of the cycle yet, or nothing of its controller; once a cycle was on
no record then."""


class Ward:
    """A room with a supervisor, which is replaced by whoever holds the campaign, as a system's
    service manager would."""

    def __init__(self, room: Room, out: Path) -> None:
        self.room, self.out = room, out
        self.truths = port.open_truth(room.truth_folder)
        self.witness = LiveJudge(port.open_truth(room.truth_folder), room.cap_mm)
        self.supervisor: Child | None = None
        self.seen: list[np.ndarray] = []
        self.database = str(room.folder / "records.db")
        self.hung: tuple[str, int] | None = None
        self.hung_s = self.replaced_s = math.inf
        """When it did, and when another one was there in its place; monotonic."""
        self._deaths_s: deque[float] = deque(maxlen=TRIES - 1)
        """Of the controller alone, the last before the supervisor would give it up."""
        self.supervise()

    def supervise(self) -> None:
        """Start a supervisor, and wait until everything works."""
        room = self.room
        self.supervisor = launch.spawn(
            room.folder, launch.SUPERVISOR, str(self.out), host=room.host
        )
        locks = (CONTROLS, RECORDS, SUPERVISES)
        assert room.wait(
            lambda: self._is_ticking() and all(map(room.holder, locks)) and self._is_recording(),
            120.0,
        )

    def _is_recording(self) -> bool:
        return Heartbeat(self.room.folder, self.room.host).age_s(Process.RECORDER) < 0.5

    def _is_ticking(self) -> bool:
        self.meanwhile()
        try:
            self.room.reopen()
            first = self.room.now("inputs.tick")
        except Exception:
            return False
        self.room.rest(LOOK_S)
        return self.room.now("inputs.tick") > first

    def begin_cycle(self) -> None:
        """From whatever rest it has come to, to a cycle that has begun.

        Not before the controller may die in it once more: it is given up after too many deaths.
        """
        room = self.room
        if len(self._deaths_s) == TRIES - 1:
            self.follow(max(self._deaths_s[0] + TRIES_S - room.now_s(), 0.0))
        assert room.wait(lambda: self._is_ticking() and room.phase() in RESTING, 60.0)
        # Of the death before people have been told, and the lamp is out again.
        assert room.wait(lambda: not self._is_missing_somebody(), 10.0)
        room.begin_cycle(self.meanwhile)

    def follow(self, seconds: float) -> None:
        """Let time go by, and see what the twin shows."""
        clock, ends_ns = self.room.host.clock, after(self.room.host.clock, seconds)
        while clock.monotonic_ns() < ends_ns:
            clock.sleep_until(min(ends_ns, after(clock, FOLLOWS_S)))
            self.meanwhile()

    def _is_missing_somebody(self) -> bool:
        self.meanwhile()
        return self.room.is_recorder_missed()

    def last_on_record(self) -> PastCycle | None:
        """The machine's last cycle on record; None of none."""
        with Records.open(self.database) as records:
            last = records.history.list_cycles(ABOUT.machine.serial, 1)
            return last[0] if last else None

    def is_settled(self) -> bool:
        """Everybody works, the machine rests, and the tip is out."""
        return self._is_ticking() and self.room.phase() in RESTING and self.room.is_out()

    def kill(self, victim: str, hung: str | None = None) -> None:
        """hung: who hangs from then on."""
        self._hang(hung)
        self.killed_s = self.room.now_s()
        for lock in VICTIMS[victim]:
            self.room.signal(self.room.holder(lock), signal.SIGKILL)
        self.dead_s = self.room.now_s()
        if victim == "control":
            self._deaths_s.append(self.dead_s)
        if victim in ("supervisor", "all"):
            assert self.supervisor is not None
            self.supervisor.wait()

    def _hang(self, name: str | None) -> None:
        """Let a process stand still for good; None: no one."""
        self.hung, self.hung_s, self.replaced_s = None, math.inf, math.inf
        if name is None:
            return
        pid = self.room.holder(LOCKS[name])
        assert pid is not None
        self.room.signal(pid, signal.SIGSTOP)
        self.hung, self.hung_s = (name, pid), self.room.now_s()

    def _look_for_its_successor(self) -> None:
        now_s = self.room.now_s()
        if self.supervisor is None or self.hung is None or self.replaced_s < math.inf:
            return
        beats = Heartbeat(self.room.folder, self.room.host)
        if beats.age_s(Process.SUPERVISOR) > now_s - self.killed_s:
            self.hung_s = now_s  # nobody looks after it yet
        name, pid = self.hung
        if self.room.holder(LOCKS[name]) not in (None, pid):
            self.replaced_s = now_s

    def wait_for_the_successor(self) -> None:
        """Until what hung was replaced, or has to be: a cycle at its end is settled before that."""
        if self.hung is None:
            return
        bound_s = BOUNDS_S[self.hung[0]] + REPLACED_S
        while self.replaced_s == math.inf and self.room.now_s() < self.hung_s + bound_s:
            self.meanwhile()
            self.room.rest(LOOK_S)

    def replacement_s(self) -> float:
        """How long what hung was in its place; 0 where nothing did."""
        return 0.0 if self.hung is None else self.replaced_s - self.hung_s

    def close(self) -> None:
        for lock in (SUPERVISES, RECORDS, CONTROLS):
            self.room.signal(self.room.holder(lock), signal.SIGKILL)
        if self.supervisor is not None:
            self.supervisor.wait()

    def meanwhile(self) -> None:
        """What the twin has shown since the last call."""
        self._look_for_its_successor()
        self.witness.look()
        found = self.truths.read()
        assert not found.missed, f"{found.missed} ticks of the twin were not looked at"
        self.seen.append(found.rows[:, SEEN])

    def beside(self, work: Callable[[], Kept]) -> Kept:
        """Do work that takes its time, while the machine goes on."""
        with ThreadPoolExecutor(1) as aside:
            looked = aside.submit(work)
            while not looked.done():
                self.meanwhile()
                self.room.rest(LOOK_S)
        return looked.result()


class SimulatedWard(Ward):
    """A ward whose time does not go by while work is done."""

    def beside(self, work: Callable[[], Kept]) -> Kept:
        """See `Ward.beside`."""
        return work()


def one(ward: Ward, victim: str, at_s: float, hung: str | None = None) -> Fate:
    """A cycle in which somebody dies. hung: who hangs from then on."""
    # The cycles of the campaign follow each other faster than any patient's.
    ward.witness.begin()
    last = ward.last_on_record()
    before = 0 if last is None else last.number
    ward.begin_cycle()
    ward.follow(at_s)
    room = ward.room
    phase, depth_mm = room.phase(), room.truth("truth.tip_mm")
    in_cycle = phase in CYCLE or phase == Phase.ABORTING
    ward.meanwhile()
    # A controller that hangs is as good as dead, to drives and people.
    lost = "control" if hung == "control" else victim
    lit = bool(shows(np.concatenate(ward.seen), lost)[-1])
    ward.seen.clear()
    looked_s = room.now_s()
    ward.kill(victim, hung)
    alive_s = ward.dead_s - looked_s  # for so long it may have lived since the last look
    if victim in ("supervisor", "all"):
        ward.supervise()
    bound_s = OUT_WITHIN_S if lost in ("control", "all") else CYCLE_WITHIN_S
    ends_s = room.now_s() + bound_s + TOLD_WITHIN_S
    while room.now_s() < ends_s:
        ward.meanwhile()
        told_s = first_told_s(np.concatenate(ward.seen), lost, lit)
        if told_s < math.inf and ward.is_settled():
            break
        room.rest(LOOK_S)
    ward.meanwhile()
    rows = np.concatenate(ward.seen)
    out_s, told_s = last_inside_s(rows, room.mouth_mm), first_told_s(rows, lost, lit)
    alone_s = first_alone_s(rows)

    def has_ended() -> bool:
        ward.meanwhile()
        last = ward.last_on_record()
        return last is not None and last.number > before and last.outcome is not None

    has_its_end = room.wait(has_ended, ON_RECORD_WITHIN_S, RECORD_LOOK_S)
    cycle, recordings, wrong = ward.beside(
        lambda: look_at_records(
            ward.database, ward.out, lost, in_cycle, is_anyone_hung=ward.hung is not None
        )
    )
    if not has_its_end:
        wrong.append(f"no end on record after cycle {before}")
    ward.wait_for_the_successor()
    if not ward.is_settled():
        wrong.append(f"not at rest: {room.phase().name}")
    if out_s > bound_s:
        wrong.append(f"inside for {out_s:.1f} s")
    if told_s > TOLD_WITHIN_S:
        wrong.append("nobody was told")
    if hung is None:
        wrong.extend(list_late_drives(victim, alone_s, room.alone_s + alive_s))
    wrong.extend(_judged(ward))
    wrong.extend(_replaced(ward))
    return Fate(
        victim=victim,
        at_s=at_s,
        phase=phase.name.lower(),
        depth_mm=depth_mm,
        out_s=out_s,
        told_s=told_s,
        alone_s=alone_s,
        lit=lit,
        outcome=str(cycle.outcome),
        detail=cycle.detail,
        recordings=recordings,
        hung=hung,
        replaced_s=ward.replacement_s(),
        wrong=tuple(wrong),
    )


def _replaced(ward: Ward) -> list[str]:
    """What took too long where a process hung."""
    took_s = ward.replacement_s()
    if ward.hung is None or took_s <= BOUNDS_S[ward.hung[0]] + REPLACED_S:
        return []
    return [f"{ward.hung[0]} that hung was replaced after {took_s:.1f} s"]


def _judged(ward: Ward) -> list[str]:
    """What the oracle says of all that the twin has played so far."""
    verdict = ward.witness.verdict()
    wrong = [f"{one.name}: {one.worst:.3g}" for one in verdict.harm]
    if verdict.inside_at_end:
        wrong.append(f"inside at {verdict.end_mm:.1f} mm")
    if verdict.missed_ticks:
        wrong.append(f"{verdict.missed_ticks} ticks that nobody judged")
    return wrong


@contextmanager
def kept_up(ward: Ward) -> Iterator[Ward]:
    """A machine whose processes may be killed, one cycle after another."""
    try:
        yield ward
    finally:
        ward.close()
