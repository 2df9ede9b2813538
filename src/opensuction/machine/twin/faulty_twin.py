"""Faults in the twin's process, each injected when it is due; requested through `twin_faults`.

The check before each tick takes one comparison. A fault that is due changes the row that is played:
the sound machine with all faults so far, as in a simulated run. A sensor that freezes keeps the
value that it showed the controller last.

A person's hand at the catheter head of a twin that plays, while its drive has let go.

It pushes until it feels something and holds there; it draws back, or lets go, when it is told to:
whoever teaches the travel length confirms in between. Once the drive has torque again it lets go,
and stays away. See `twin.machine.dc_axis`; asked for by
`twin_faults.hold`.
"""

import json
import math
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from opensuction.host.host import Host
from opensuction.host.this_computer import THIS_COMPUTER
from opensuction.ipc.ring import EventWriter, FollowedRing
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Readings
from opensuction.kernel.vocabulary import Phase
from opensuction.machine.port import HandTask
from opensuction.machine.twin.twin_faults import (
    ANSWER,
    BUS,
    CAME,
    CHANGE,
    EVENTS,
    HEALED,
    PHASE,
    PHASES,
    TAKEN,
    check,
)
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection.fault_instant import (
    FaultInstant,
    FaultySide,
    Injection,
    Instant,
)
from opensuction.simulation.injection.injection import MOST_FAULTS
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineCall, MachineSide
from opensuction.twin.fault import link
from opensuction.twin.fault.bus import Bus
from opensuction.twin.fault.fault import BY_NAME
from opensuction.twin.machine import dc_axis
from opensuction.twin.machine.dc_axis import AWAY, NOBODY, PUSHING, Hand, HandStage, HandState

HOLDS_S = 600.0
"""It holds the head until it is told what to do next; nobody has that much patience."""
PERSON = 5
"""Number of the person; those who teach in simulated runs have others."""


class Held(NamedTuple):
    """A hand and what it does now."""

    hand: Hand
    state: HandState


def held(task: HandTask, park_head_mm: float, quick_mm: float, seed: int) -> Held:
    """The hand that does it.

    park_head_mm: where it lets go on the way back. quick_mm: length of the way inside the tube.
    seed: draws the person. Raises InputError for what is no place.
    """
    if not (math.isfinite(park_head_mm) and math.isfinite(quick_mm)):
        raise InputError(f"a hand at {park_head_mm:g} mm, {quick_mm:g} mm quickly: no places")
    person = dc_axis.draw_hand(park_head_mm, quick_mm, seed, PERSON)
    if task == HandTask.PUSH:
        return Held(person._replace(hold_s=HOLDS_S), PUSHING)
    if task == HandTask.DRAW:
        return Held(person, AWAY._replace(stage=HandStage.PULLING.value))
    return Held(NOBODY, AWAY)


LARGEST = 1 << 16
"""Bytes of a message."""
LOOK_TICKS = 50
"""How often another controller's ring is looked for."""
NEVER = math.inf
_INSERTION_ON = SHOWN_COLUMNS.index("commands.insertion_on")
_READINGS = [i for i, name in enumerate(SHOWN_COLUMNS) if name.startswith("readings.")]


class _Waiting(NamedTuple):
    """A fault that is to come."""

    injection: Injection
    due: float
    """First tick with it; `NEVER` while its phase has not begun."""


class _Phases:
    """The controller's phases, as they begin."""

    def __init__(self, path: Path) -> None:
        self._ring = FollowedRing(path, lambda columns: PHASE in columns)
        self._place = 0
        self._last: float | None = None
        self._looked = 0

    def look(self) -> set[int]:
        """Phases that have begun since the last call; that of the first call has begun before."""
        first = self._ring.reader is None
        if self._looked % LOOK_TICKS == 0 and self._ring.look() and self._ring.reader is not None:
            reader = self._ring.reader
            self._place = reader.facts.columns.index(PHASE)
            newest = reader.snapshot() if first else None
            self._last = None
            if newest is not None:
                reader.next, self._last = newest[0] + 1, newest[1][self._place]
        self._looked += 1
        if self._ring.reader is None:
            return set()
        begun = set()
        for phase in self._ring.reader.read().rows[:, self._place]:
            if phase != self._last:
                begun.add(int(phase))
            self._last = phase
        return begun


class FaultyTwin:
    """Breaks a machine that is stepped elsewhere, and says what it did."""

    def __init__(self, folder: Path, call: MachineCall, host: Host = THIS_COMPUTER) -> None:
        """call: whose row is played. Raises InputError where another twin plays in the folder."""
        self._call, self._folder, self.tick = call, folder, 0
        self._sound = plain_row.unpack(MachineSide, call.side_row)
        self._hand = self._sound.machine.hand
        self._side = self._fresh()
        self._waiting: list[_Waiting] = []
        self._came = 0
        self._due: float = NEVER
        """Before which tick there is something to do next."""
        self._phases: _Phases | None = None
        self._events = EventWriter(folder / EVENTS, host=host)
        self._asked = host.datagrams.listen(folder / CHANGE)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._asked.close()
        self._events.__exit__()

    @property
    def is_sound(self) -> bool:
        """True where nothing is to come, and nobody holds the catheter."""
        return self._due == NEVER and self._phases is None and not self._hand.present

    def step(self) -> None:
        """Do what is due before the next tick. To be called once a tick."""
        if self.tick >= self._due:
            self._change()
        self.tick += 1

    def look(self) -> None:
        """Hear what is asked, and what phase begins; a hand lets go of a head that is driven."""
        if self._hand.present and self._call.shown_row[_INSERTION_ON]:
            self._let_go()
        if self._phases is not None:
            self._await_phases(self._phases.look())
        if (data := self._asked.receive(LARGEST)) is None:
            return
        if len(data) == self._call.side_row.nbytes:
            self._sound = plain_row.unpack(MachineSide, np.frombuffer(data))
            self._hand = self._sound.machine.hand
            self._heal()
        else:
            self._obey(data)

    def _fresh(self) -> FaultySide:
        """The machine as it was built."""
        wires = self._sound.wiring.link
        return FaultySide(self._sound.machine, wires, wires.stream.key_0)

    def _obey(self, data: bytes) -> None:
        """Take what was asked, or say why not."""
        try:
            asked = json.loads(data)
            key = str(asked["key"])
        except (ValueError, KeyError, TypeError):
            return
        try:
            self._take(asked)
            reason = TAKEN
        except InputError as error:
            reason = str(error)
        except (ValueError, KeyError, TypeError) as error:
            reason = f"the twin does not understand {data!r}: {error}"
        self._events.write(ANSWER, self.tick, key=key, reason=reason)

    def _take(self, asked: dict[str, Any]) -> None:
        if "faults" in asked:
            faults = [self._read_fault(*one) for one in asked["faults"]]
            check([one.injection for one in faults])
            if self._came + len(self._waiting) + len(faults) > MOST_FAULTS:
                raise InputError(
                    f"{self._came + len(self._waiting)} faults are there or to come, and "
                    f"{len(faults)} more asked for: at most {MOST_FAULTS}; mend them first"
                )
            self._waiting += faults
            if any(one.due == NEVER for one in faults) and self._phases is None:
                self._phases = _Phases(self._folder / PHASES)
        elif "heal" in asked:
            self._heal()
            self._events.write(HEALED, self.tick)
        elif "hand" in asked:
            self._hold(*asked["hand"])
        else:
            self._ride(Bus(*(float(value) for value in asked["bus"])))
        self._plan()

    def _hold(self, task: str, park_head_mm: float, quick_mm: float) -> None:
        """Another task for the hand at the catheter head."""
        seed = int(self._sound.wiring.link.stream.key_0)
        found = held(HandTask(task), float(park_head_mm), float(quick_mm), seed)
        self._hand = found.hand
        self._call.put_hand(found.state)
        self._play()

    def _let_go(self) -> None:
        """Nobody holds the catheter head."""
        self._hand = NOBODY
        self._call.put_hand(AWAY)
        self._play()

    def _read_fault(
        self, name: str, phase: int | None, after_s: float, strength: float
    ) -> _Waiting:
        at = FaultInstant(None if phase is None else Phase(phase), float(after_s))
        due = NEVER if phase is not None else self.tick + round(at.after_s / DT_S)
        return _Waiting(Injection(BY_NAME[name], at, float(strength)), due)

    def _await_phases(self, begun: set[int]) -> None:
        """Some phases have begun: faults that wait for them come so long after."""
        for place, one in enumerate(self._waiting):
            if one.due == NEVER and one.injection.at.phase in begun:
                after = max(round(one.injection.at.after_s / DT_S), 1)
                # The tick that is told of a phase has been its first.
                self._waiting[place] = one._replace(due=self.tick + after - 1)
        if not any(one.due == NEVER for one in self._waiting):
            self._phases = None
        self._plan()

    def _plan(self) -> None:
        coming = [one.due for one in self._waiting]
        known = self._side.next_done
        self._due = min(coming if known is None else [*coming, known], default=NEVER)

    def _change(self) -> None:
        """Make the changes that are due."""
        for one in [one for one in self._waiting if one.due <= self.tick]:
            self._waiting.remove(one)
            readings = plain_row.unpack(Readings, self._call.shown_row[_READINGS])
            self._side.inject(one.injection, Instant(self.tick, self.tick), readings)
            self._came += 1
            told = {"fault": one.injection.fault.title, "strength": str(one.injection.strength)}
            self._events.write(CAME, self.tick, **told)
        self._side.follow(self.tick)
        if self._side.restart_done is not None and self._side.restart_done <= self.tick:
            self._side.restart(self.tick)
        self._play()
        self._plan()

    def _ride(self, carrier: Bus) -> None:
        """Another bus under the sound link."""
        if self._came:
            raise InputError("the bus cannot be changed while faults are there: mend them first")
        wiring = self._sound.wiring
        self._sound = self._sound._replace(
            wiring=wiring._replace(link=link.on_bus(wiring.link, carrier, DT_S))
        )
        self._side = self._fresh()
        self._events.write(BUS, self.tick, **{k: str(v) for k, v in carrier._asdict().items()})
        self._play()

    def _heal(self) -> None:
        self._side, self._waiting, self._came, self._phases = self._fresh(), [], 0, None
        self._play()
        self._plan()

    def _play(self) -> None:
        """From the next tick on, what is broken by now."""
        side = self._side
        played = self._sound._replace(
            machine=side.machine._replace(hand=self._hand),
            wiring=self._sound.wiring._replace(link=side.link),
        )
        self._call.side_row[:] = plain_row.pack(MachineSide, played)
