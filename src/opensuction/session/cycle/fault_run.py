"""One cycle in which something goes wrong, and what noticed it, in records and words."""

import math

from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import START
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle import lock_out
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.procedure.cycle.transition import Event
from opensuction.result.cycle_result import FaultNotice, FaultRecord
from opensuction.safety.condition import Condition
from opensuction.session.cycle import cycle_run
from opensuction.session.cycle.cycle_run import AFTERMATH_S, Prepared, Watch
from opensuction.session.cycle.cycle_summary import ABORT_SENTENCES
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.faulty_run import RESTARTING
from opensuction.simulation.injection.injection import Detector, FirstSign, Injected, InjectedRun
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault_table import ROWS

RESETS = 2
"""After a new controller has started a person lets it recover, and resets it once more."""
UNAIDED = {
    Condition.WATCHDOG_FIRED: "the drives heard nothing new from the controller and acted on their "
    "own",
    Condition.MESSAGE_LATE: "the drives saw that the controller's commands came late, or not at "
    "all",
    Condition.RESERVE_ENERGY_USED: "the power supply saw that the mains had failed",
}
"""What the annunciator tells without a controller."""


def play(prepared: Prepared, watch: Watch) -> InjectedRun:
    """Run the cycle with the faults of its choice; without any it is the healthy cycle.

    watch: hears of each piece. Raises InputError where the cycle is over before a fault's instant.
    """
    faults = prepared.resolved.faults
    if not faults:
        return cycle_run.run(prepared, prepared.start, START, watch)

    restarts = any(one.fault in RESTARTING for one in faults)
    later = [one for one in faults if not ROWS[one.fault].is_planned]
    found = injection.run(
        prepared.loop,
        prepared.start,
        later,
        after_s=AFTERMATH_S if prepared.rig.machine.has_patient else injection.AFTERMATH_S,
        resets=RESETS if restarts else 0,
        seed=prepared.rig.seed,
        watcher=cycle_run.call_by_piece(watch),
    )
    if len(later) == 1 and math.isnan(found.faults[0].at_s):
        last_s = found.columns["time_s"].size * DT_S
        raise InputError(
            f"fault '{later[0].fault.title}' at {later[0].at.title} never comes: the run is over "
            f"after {last_s:.1f} s, or that phase after less"
        )
    planned = [
        Injected(one, 0.0, injection.find_first_sign(found, 0.0))
        for one in faults
        if one not in later
    ]
    return found._replace(faults=(*planned, *found.faults))


def _sentence(notice: FirstSign, columns: Columns) -> str:
    if notice.detector == Detector.TRIP:
        return Condition(notice.code).row.sentence
    if notice.detector == Detector.CHECK:
        return f"the pre-use test failed: {CheckItem(notice.code).failure}"
    if notice.detector == Detector.REFUSAL:
        return f"the start was refused: {lock_out.SENTENCES[Refusal(notice.code)]}"
    if notice.detector == Detector.DRIVE:
        return UNAIDED[Condition(notice.code)]
    before = max(round(notice.time_s / DT_S) - 1, 0)
    phase = Phase(int(columns["phase"][before])).name.lower()
    return ABORT_SENTENCES[Event(notice.code)].format(phase=phase, failed="")


def _noticed(found: Injected, columns: Columns) -> FaultNotice | None:
    notice = found.notice
    if notice is None:
        return None
    return FaultNotice(
        by=notice.detector.name.lower(),
        name=notice.title,
        sentence=_sentence(notice, columns),
        time_s=notice.time_s,
        after_s=notice.time_s - found.at_s,
    )


def on_record(run: InjectedRun) -> tuple[FaultRecord, ...]:
    """Each fault of a run, when it came and what noticed it first."""
    listed = []
    for found in run.faults:
        fault, at, strength = found.injection
        row = ROWS[fault]
        listed.append(
            FaultRecord(
                name=fault.title,
                meaning=row.meaning,
                instant=at.title,
                at_s=None if math.isnan(found.at_s) else found.at_s,
                strength=None if row.strength is None else strength,
                strength_unit=None if row.strength is None else row.strength.unit,
                noticed=_noticed(found, run.columns),
            )
        )
    return tuple(listed)
