"""A day of cycles on one patient: the controller's own clock starts them, secretions gather.

Between cycles the machine is parked: the patient breathes on and the controller's clocks run, but
its ticks are not played (`simulation.closed_loop`). Before each cycle a person comes
(`simulated_caregiver`): gives oxygen where it is asked for, looks at the patient after as many
passes as may follow each other, changes a catheter whose 24 h would end. With self-calibration each
cycle shows how wide the gap is and where the tip lies, and the next cycle compensates that.

The patient over a day: secretions, saturation and volume lost, sampled as time passes.

Actions of a person between the cycles of a day: assessment, a new catheter, oxygen.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from opensuction.controller import setup
from opensuction.identification.estimator.adaptation import AdaptationChange
from opensuction.kernel.interface import (
    ASSESSED,
    CHANGED,
    NO_REQUESTS,
    RETURN_TO_SERVICE,
    SERVICE,
    START,
    Requests,
)
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import interlocks, schedule
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.schedule import ScheduleMode
from opensuction.result.cycle_result import FaultRecord
from opensuction.result.day_result import DaySamples
from opensuction.session.choice import DayChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.day import day_calibration
from opensuction.session.day.day_fault import FaultyDay
from opensuction.simulation import closed_loop, trace
from opensuction.simulation.closed_loop import DT_S, LoopState
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.simulation.outcome import Outcome
from opensuction.simulation.trace import Columns
from opensuction.twin import bedside

WORN = (Refusal.CATHETER_LIFE_OVER, Refusal.CATHETER_LIFE_ENDS)


class Attended(NamedTuple):
    """A machine that somebody has been at, about to begin a cycle."""

    ready: Prepared
    """For this cycle: with the oxygen on that was given for it."""
    catheter_changed: bool
    assessed: bool
    """The person looked at the patient, for as many passes as may follow each other were made."""


def _press(prepared: Prepared, state: LoopState, requests: Requests) -> LoopState:
    """One tick in which somebody presses a button."""
    return closed_loop.run(prepared.loop, state, requests, trace.rows(DT_S))[0]


def _is_worn(prepared: Prepared, state: LoopState) -> bool:
    settings = prepared.loop.controller
    refusal = interlocks.refusal(
        settings.service,
        state.controller.core.upkeep,
        Phase.PARKED.value,
        settings.plan.travel_known,
        state.controller.core.governor.patient.conditions,
    )
    return refusal in WORN


def _renew(prepared: Prepared, state: LoopState) -> LoopState:
    """The loop after a person has put a new catheter in; the old one's mucus goes with it."""
    for requests in (SERVICE, CHANGED, RETURN_TO_SERVICE):
        state = _press(prepared, state, requests)
    bore = state.machine.bore._replace(mucus_ml=0.0, tail_ml=0.0, front_ml=0.0)
    return state._replace(machine=state.machine._replace(bore=bore))


def lead_s(prepared: Prepared) -> float:
    """Time before a cycle at which the person comes, in s."""
    return resolution.lead_s(prepared.loop, prepared.resolved.choice.preoxygenation)


def attend(prepared: Prepared, state: LoopState) -> Attended:
    """Somebody comes before a cycle and does what it needs."""
    rule = prepared.loop.controller.service.passes
    assessed = bool(schedule.is_exhausted(rule, state.controller.core.upkeep.episode))
    if assessed:
        state = _press(prepared, state, ASSESSED)
    worn = _is_worn(prepared, state)
    if worn:
        state = _renew(prepared, state)
    chosen = prepared.resolved.choice.preoxygenation
    loop, state = resolution.give(prepared.loop, state, chosen)
    return Attended(prepared._replace(loop=loop, start=state), worn, assessed)


Sample = tuple[float, float, float, float]
"""One row of `DaySamples`."""


def sum_secretion_ml(state: LoopState) -> float:
    """Secretions in the airway, in mL; those that suction cannot reach are among them."""
    return bedside.sum_secretion_ml(state.bedside)


def look_at(state: LoopState) -> Sample:
    """The patient as it is now."""
    signs = state.machine.coupling.signs
    seen = signs.spo2_percent, signs.lung_volume_loss_ml
    return state.tick * DT_S, sum_secretion_ml(state), *seen


def look_back(state: LoopState, columns: Columns) -> list[Sample]:
    """The patient during a cycle, once a second, and as it is after it."""
    removed = columns["truth.secretion_removed_ml"]
    after_ml = sum_secretion_ml(state)
    seen = (
        columns["time_s"],
        after_ml + (removed[-1] - removed),
        columns["truth.spo2_percent"],
        columns["truth.lung_volume_loss_ml"],
    )
    every = np.column_stack([values[:: round(1.0 / DT_S)] for values in seen])
    return [*map(tuple, every.tolist()), look_at(state)]


SAMPLE_S = 60.0
"""Patient and secretions are looked at this often between cycles."""
WAKE_S = 0.5
"""The closed loop is played again this long before a cycle is due."""


class DayCycle(NamedTuple):
    """One cycle of a day."""

    number: int
    start_s: float
    outcome: Outcome
    secretion_before_ml: float
    """In the trachea when the cycle began."""
    bore_ml: float
    """Mucus that stays in the catheter afterwards."""
    catheter_age_s: float
    """At the end of the cycle."""
    catheter_changed: bool
    """Just before it."""
    assessed: bool
    """A person looked at the patient just before it, for the passes of the machine were used up."""
    preoxygenation: str
    """What is on record: confirmed, skipped or not-required."""
    learned: AdaptationChange | None
    """What it showed of gap and tip; None without self-calibration or where it was broken off."""


class Day(NamedTuple):
    """A day, or what was done of it before a cycle was broken off."""

    asked: DayChoice
    cycles: tuple[DayCycle, ...]
    samples: DaySamples
    last: Prepared
    """The last cycle, as it began."""
    columns: Columns
    """Its trace, from its first tick."""
    ran: InjectedRun
    """It as it was played, with the ticks before it in which the machine was still parked."""
    produced_ml: float
    canister_ml: float
    left_ml: float
    """In the airway at the end."""
    coughed_ml: float
    """Coughed out through the tube."""
    refusal: str | None
    """Why self-calibration let no further cycle begin."""
    faults: tuple[FaultRecord, ...] = ()
    """Each with the number of its cycle."""
    reset_cycles: tuple[int, ...] = ()
    """Numbers of the cycles after which a person reset the machine."""


def _waited(
    prepared: Prepared, state: LoopState, until_s: float, samples: list[Sample]
) -> LoopState:
    """The loop parked until the schedule is about to act."""
    while True:
        left_s = until_s - state.controller.core.upkeep.schedule.since_cycle_s
        span_s = min(SAMPLE_S, left_s)
        if span_s < closed_loop.STEP_S:
            return state
        state = resolution.pass_idle_time(prepared.loop, state, span_s)
        samples.append(look_at(state))


def play(
    prepared: Prepared,
    asked: DayChoice,
    tell: Callable[[DayCycle, Prepared, Columns], None],
) -> Day:
    """Cycles at intervals, the first on request, the others started by the controller's clock.

    tell: hears of each cycle when it is over, as it began and with its trace from its start. A
    cycle that does not end parked ends the day: a halted machine waits for a person, as does a gap
    out of its range; where faults were asked for a person resets it (see `day_fault`).
    """
    prepared = _set_schedule(prepared, asked.every_s)
    # The day begins with the first cycle, for which somebody has just given oxygen.
    attended = attend(prepared, prepared.start)
    state = attended.ready.start._replace(tick=0)
    began_ml = sum_secretion_ml(state)
    samples: list[Sample] = []
    cycles: list[DayCycle] = []
    learning = day_calibration.begun(prepared) if asked.self_calibrates else None
    faulty = FaultyDay(prepared, asked) if prepared.resolved.faults else None
    while len(cycles) < asked.repeat:
        if cycles:
            sick = prepared if faulty is None else faulty.afflict(prepared)
            attended = _await_person(sick, asked, state, samples)
            state = attended.ready.start
        now = _play_cycle(attended, faulty, state, len(cycles) + 1, samples)
        state, done = now.state, now.done
        if learning is not None and done.outcome.completed:
            learning = day_calibration.learned(learning, prepared, now.columns)
            done = done._replace(learned=learning.change)
        cycles.append(done)
        tell(done, now.ready, _from_zero(now.columns))
        refusal = None if learning is None else learning.refusal
        if _waits_for_a_person(state, faulty) or refusal is not None:
            break
        if learning is not None and len(cycles) < asked.repeat:
            prepared, state, learning = day_calibration.applied(learning, prepared, state)
            if learning.refusal is not None:
                break
    refusal = None if learning is None else learning.refusal
    return _sum_up(asked, cycles, now, began_ml, samples, refusal, faulty)


class _PlayedCycle(NamedTuple):
    """One cycle of a day, as it was played."""

    done: DayCycle
    ready: Prepared
    """As it began."""
    state: LoopState
    """After it."""
    columns: Columns
    """Its trace from its first tick, on the clock of the day."""
    ran: InjectedRun
    """As it was played."""


def _set_schedule(prepared: Prepared, every_s: float) -> Prepared:
    """The machine, its controller set to start a cycle by its clock."""
    timed = setup.with_schedule(
        prepared.loop.controller, schedule.schedule(ScheduleMode.TIMED, every_s)
    )
    return prepared._replace(loop=prepared.loop._replace(controller=timed))


def _await_person(
    prepared: Prepared, asked: DayChoice, state: LoopState, samples: list[Sample]
) -> Attended:
    """The machine parked until somebody comes before the next cycle, and what that person does."""
    comes_s = asked.every_s - WAKE_S - lead_s(prepared)
    return attend(prepared, _waited(prepared, state, comes_s, samples))


def _play_cycle(
    attended: Attended,
    faulty: FaultyDay | None,
    state: LoopState,
    number: int,
    samples: list[Sample],
) -> _PlayedCycle:
    """One cycle from this state on; `samples` has the patient during it afterwards."""
    # After a change of catheter the clock begins anew: the person starts this cycle.
    by_hand = attended.catheter_changed or number == 1
    ready = attended.ready._replace(start=state)
    ran = _played(ready, faulty, state, START if by_hand else NO_REQUESTS)
    samples += look_back(ran.state, ran.columns)
    columns = _from_its_start(ran.columns)
    done = _cycle(attended, ready, ran.state, columns, number)
    return _PlayedCycle(done, ready, ran.state, columns, ran)


def _sum_up(
    asked: DayChoice,
    cycles: list[DayCycle],
    last: _PlayedCycle,
    began_ml: float,
    samples: list[Sample],
    refusal: str | None,
    faulty: FaultyDay | None,
) -> Day:
    """The day, after its last cycle. began_ml: secretions in the trachea when it began."""
    left_ml = sum_secretion_ml(last.state)
    coughed_ml = last.state.bedside.store.expelled_ml
    removed_ml = sum(cycle.outcome.removed_ml for cycle in cycles)
    return Day(
        asked=asked,
        cycles=tuple(cycles),
        samples=DaySamples(*np.array(samples).T),
        last=last.ready,
        columns=_from_zero(last.columns),
        ran=last.ran,
        produced_ml=left_ml + removed_ml + coughed_ml - began_ml,
        canister_ml=last.state.machine.bore.canister_ml,
        left_ml=left_ml,
        coughed_ml=coughed_ml,
        refusal=refusal,
        faults=() if faulty is None else faulty.on_record(),
        reset_cycles=() if faulty is None else tuple(faulty.reset_cycles),
    )


def _played(
    ready: Prepared, faulty: FaultyDay | None, state: LoopState, requests: Requests
) -> InjectedRun:
    """One cycle, with what is broken."""
    if faulty is None:
        return cycle_run.run(ready, state, requests)
    return faulty.play(ready, state, requests)


def _waits_for_a_person(state: LoopState, faulty: FaultyDay | None) -> bool:
    """True if the machine has halted, or has no controller."""
    if faulty is not None and faulty.is_over:
        return True
    return state.controller.core.procedure.phase != Phase.PARKED


def _from_its_start(columns: Columns) -> Columns:
    """A trace without the ticks in which the machine was still parked."""
    first = int(np.argmax(columns["phase"] != Phase.PARKED))
    return {name: values[first:] for name, values in columns.items()}


def _from_zero(columns: Columns) -> Columns:
    """A trace with a clock of its own."""
    return {**columns, "time_s": columns["time_s"] - columns["time_s"][0]}


def _cycle(
    attended: Attended, prepared: Prepared, state: LoopState, columns: Columns, number: int
) -> DayCycle:
    start_s = float(columns["time_s"][0])
    return DayCycle(
        number=number,
        start_s=start_s,
        outcome=cycle_run.figures(prepared, columns),
        secretion_before_ml=sum_secretion_ml(prepared.start),
        bore_ml=state.machine.bore.mucus_ml,
        catheter_age_s=state.controller.core.upkeep.catheter_age_s,
        catheter_changed=attended.catheter_changed,
        assessed=attended.assessed,
        preoxygenation=resolution.on_record(columns).state,
        learned=None,
    )
