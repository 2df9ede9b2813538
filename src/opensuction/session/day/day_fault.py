"""Faults in a day of cycles: in which cycle each comes, and how the day goes on with it.

An instant in seconds counts from the start of the day, one in a phase from the first cycle that has
it. What is broken stays broken. A machine that has halted is reset by a person; if it does not park
then, or has no controller, the day is over.

Check of the choices for a day of cycles.
"""

import math
from typing import NamedTuple

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Requests
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.interlocks import LIFE_S
from opensuction.procedure.cycle.schedule import ScheduleMode
from opensuction.result.cycle_result import FaultRecord
from opensuction.session.choice import DayChoice
from opensuction.session.cycle import fault_run
from opensuction.session.cycle.cycle_run import AFTERMATH_S, Prepared
from opensuction.session.cycle.resolution import ResolvedCycle
from opensuction.simulation.closed_loop import LoopState
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import AT_START, FaultInstant, Injection
from opensuction.simulation.injection.faulty_run import FaultyRun, RowBuffer
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.twin import preset
from opensuction.twin.fault.fault_table import ROWS

RESETS = fault_run.RESETS
"""[assumed] A person lets a halted machine bring the catheter out, and resets it once more."""


class DayFault(NamedTuple):
    """A fault of a day."""

    injection: Injection
    """As a person wrote it."""
    cycle: int
    """The first in which it can come."""
    at: FaultInstant
    """Its instant in that cycle."""


def place(asked: DayChoice, one: Injection) -> DayFault:
    """The cycle of a day in which a fault comes, and its instant there.

    Between two cycles nothing is played: what comes then is there when the next one begins. Raises
    InputError for an instant after the last cycle.
    """
    if one.at.phase is not None or ROWS[one.fault].is_setup:
        return DayFault(one, 1, one.at)
    before = int(one.at.after_s // asked.every_s)
    at = FaultInstant(None, one.at.after_s - before * asked.every_s)
    if at.after_s >= injection.LIMIT_S:
        before, at = before + 1, AT_START
    if before >= asked.repeat:
        raise InputError(
            f"fault '{one.fault.title}' at {one.at.title}: the last of {asked.repeat} cycles is "
            f"over by then; they come every {asked.every_s:g} s"
        )
    return DayFault(one, before + 1, at)


def place_all(asked: DayChoice, faults: tuple[Injection, ...]) -> tuple[DayFault, ...]:
    """`place` for each of a day's faults, those of the planning left out."""
    return tuple(place(asked, one) for one in faults if not ROWS[one.fault].is_planned)


class FaultyDay:
    """The cycles of a day with faults, played one after the other on one machine."""

    def __init__(self, prepared: Prepared, asked: DayChoice) -> None:
        self._faults = place_all(asked, prepared.resolved.faults)
        self._room: RowBuffer = injection.make_room(AFTERMATH_S, RESETS)
        self._going: FaultyRun | None = None
        self._number = 0
        self._seed = prepared.rig.seed
        self._came: dict[int, FaultRecord] = {}
        """By the fault's place: what is said of it."""
        self.reset_cycles: list[int] = []
        """Numbers of the cycles after which a person reset the machine."""

    def play(self, prepared: Prepared, state: LoopState, requests: Requests) -> InjectedRun:
        """One cycle and what follows it."""
        self._number += 1
        if self._going is None:
            self._going = FaultyRun(prepared.loop, state, self._injections, self._room, self._seed)
            self._going.requests = requests
        else:
            self._going.carry_on(prepared.loop, state, requests)
        for i, one in enumerate(self._faults):
            self._going.hold(i, one.cycle > self._number)
        if injection.follow(self._going, AFTERMATH_S, RESETS):
            self.reset_cycles.append(self._number)
        ran = injection.take(self._going, self._injections)
        self._note(ran)
        # The next cycle overwrites the room's.
        columns = {name: column.copy() for name, column in ran.columns.items()}
        sent = {
            name: columns[name] if column is ran.columns[name] else column.copy()
            for name, column in ran.sent.items()
        }
        return ran._replace(columns=columns, sent=sent)

    def afflict(self, prepared: Prepared) -> Prepared:
        """A machine with the faults that have come, for the time between two cycles."""
        if self._going is None:
            return prepared
        oxygen_ratio = prepared.loop.machine.patient.ventilator.oxygen_ratio
        broken = preset.ventilate(self._going.loop.machine, oxygen_ratio)
        return prepared._replace(loop=prepared.loop._replace(machine=broken))

    @property
    def is_over(self) -> bool:
        """True once no further cycle can begin: no controller runs."""
        return self._going is not None and not self._going.is_resting

    def on_record(self) -> tuple[FaultRecord, ...]:
        """Each fault, when it came and what noticed it first; as for a cycle, and in which one.

        Raises InputError for a fault alone whose instant never came.
        """
        if len(self._faults) == 1 and not self._came:
            one = self._faults[0].injection
            raise InputError(
                f"fault '{one.fault.title}' at {one.at.title} never comes: no cycle of the day "
                "gets there"
            )
        return tuple(self._came[i] for i in sorted(self._came))

    @property
    def _injections(self) -> list[Injection]:
        return [one.injection._replace(at=one.at) for one in self._faults]

    def _note(self, ran: InjectedRun) -> None:
        """Keep what came in this cycle, or was noticed in it of what had come before."""
        time_s = ran.columns["time_s"]
        ran = ran._replace(columns={**ran.columns, "time_s": time_s - time_s[0]})
        for i, found in enumerate(ran.faults):
            known = self._came.get(i)
            if math.isnan(found.at_s) or (known is not None and known.noticed is not None):
                continue
            notice = injection.find_first_sign(ran, found.at_s)
            (said,) = fault_run.on_record(ran._replace(faults=(found._replace(notice=notice),)))
            if known is None:
                title = self._faults[i].injection.at.title
                known = said._replace(instant=title, cycle=self._number)
            noticed = said.noticed and said.noticed._replace(cycle=self._number)
            self._came[i] = known._replace(noticed=noticed)


MOST_CYCLES = 500
"""More would be weeks: a trial, not a day."""
MOST_INTERVAL_S = LIFE_S
"""[design] A catheter is changed by then: what begins later is another day."""


def check(day: DayChoice, resolved: ResolvedCycle) -> None:
    """Refuse what is no day of this cycle; raises InputError."""
    repeat, every_min = day.repeat, day.every_min
    if repeat > MOST_CYCLES:
        raise InputError(f"--repeat {repeat}: should be at most {MOST_CYCLES}")
    if every_min is not None and repeat < 2:
        raise InputError(f"--every {every_min:g} says nothing without --repeat 2 or more")
    if repeat > 1 and every_min is None:
        raise InputError(f"--repeat {repeat} needs --every MIN: minutes from start to start")
    if repeat > 1 and resolved.equipment.on_bench:
        raise InputError("--repeat is for a patient, and the bench has none: use another protocol")
    if every_min is not None:
        if day.every_s > MOST_INTERVAL_S:
            raise InputError(
                f"--every {every_min:g}: should be at most {MOST_INTERVAL_S / 60.0:g} min, the "
                "longest that a catheter is used"
            )
        schedule.schedule(ScheduleMode.TIMED, day.every_s)
    if repeat == 1:
        injection.check(resolved.faults)
    else:
        place_all(day, resolved.faults)
    if day.self_calibrates:
        _check_learning(day, resolved)


def _check_learning(day: DayChoice, resolved: ResolvedCycle) -> None:
    """Refuse self-calibration where nothing could be learned or used; raises InputError."""
    if day.repeat < 2:
        raise InputError(
            "--self-calibrate is for the next cycle: add --repeat 2 or more, and --every MIN"
        )
    if resolved.compensation == CompensationKind.NONE:
        raise InputError(
            "--self-calibrate finds gap and offset, and compensation 'none' uses neither: use "
            "another, for example preview"
        )
    backoff_mm = resolved.protocol.backoff_mm
    if resolved.by_contact and backoff_mm <= 0.0:
        raise InputError(
            f"--self-calibrate needs a reversal at the carina, and backoff_mm is "
            f"{backoff_mm:g} mm: set it to 1 mm or more"
        )
