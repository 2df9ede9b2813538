"""Result of a day of cycles, and what self-calibration found in it, in words.

The report of each cycle of a day, made when it is over: its trace is too large to be kept.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from opensuction.identification.estimator.adaptation import (
    SPOILT,
    AdaptationChange,
    Finding,
    Spoilt,
)
from opensuction.identification.estimator.gap_measurement import SENTENCES, Missed
from opensuction.kernel.unit import HOUR_S
from opensuction.kernel.vocabulary import name_of
from opensuction.procedure.cycle import schedule
from opensuction.procedure.cycle.schedule import ScheduleMode
from opensuction.report import headline
from opensuction.report.cycle import page
from opensuction.report.figure import FigureVerdict
from opensuction.report.wording import capitalise
from opensuction.result.cycle_result import AlarmRecord
from opensuction.result.day_result import CycleNews, DayCycleResult, DayResult, GapResult
from opensuction.result.plain import measured
from opensuction.safety.alarm.alarm_log import Episode
from opensuction.safety.condition import Condition
from opensuction.session.cycle import cycle_summary, summary_section
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.session.day import day_calibration
from opensuction.session.day.day_run import Day, DayCycle
from opensuction.simulation.trace import Columns

MOST_PAGES = 48
"""Of a longer day only the cycles that need a look have a page beyond these: 150 kB each."""


class CycleReport(NamedTuple):
    """Report of one cycle of a day."""

    file: str
    """Name of its page; empty where it has none."""
    html: str
    first: headline.Headline
    """What a person must know of it."""


def make(number: int, prepared: Prepared, columns: Columns) -> CycleReport:
    """The report of one cycle. number: its place in the day, from 1. columns: from its start."""
    data = cycle_summary.summary(prepared, columns)
    first = headline.headline(data)
    if number > MOST_PAGES and first.verdict is FigureVerdict.GOOD:
        return CycleReport("", "", first)
    html = page.render(data, columns, summary_section.sections(prepared), is_one_of_many=True)
    return CycleReport(f"cycle-{number:03d}.html", html, first)


def cycle_news(report: CycleReport) -> CycleNews:
    """First thing to know of a cycle, for its row in the day's result."""
    return CycleNews(report.first.text, report.first.verdict.value, report.file or None)


def list_pages(reports: list[CycleReport]) -> dict[str, str]:
    """Pages by the names of their files."""
    return {report.file: report.html for report in reports if report.file}


MINUTE_S = 60.0
CONDITION = Condition.CALIBRATION_OUT_OF_RANGE


def _row(cycle: DayCycle, news: CycleNews | None) -> DayCycleResult:
    found = cycle.outcome
    return DayCycleResult(
        number=cycle.number,
        start_min=cycle.start_s / MINUTE_S,
        outcome="completed" if found.completed else "aborted",
        rmse_mm=found.rmse_mm,
        secretion_before_ml=cycle.secretion_before_ml,
        removed_ml=found.removed_ml,
        removed_percent=found.removed_percent,
        bore_ml=cycle.bore_ml,
        negative_pressure_s=found.negative_pressure_s,
        in_airway_s=found.exposure.in_airway_s,
        inside_at_end=found.exposure.inside_at_end,
        end_mm=found.exposure.end_mm,
        harm=tuple(one.name for one in found.harm),
        told=cycle_summary.told(found.told),
        spo2_nadir_percent=found.exposure.spo2_least_percent,
        lung_volume_loss_ml=found.exposure.lung_volume_loss_ml,
        trips=tuple(name_of(item.trip) for item in found.trips),
        alarms=cycle_summary.alarms(found.alarms),
        catheter_age_h=cycle.catheter_age_s / HOUR_S,
        catheter_changed=cycle.catheter_changed,
        assessed=cycle.assessed,
        preoxygenation=cycle.preoxygenation,
        gap=_gap(cycle.learned),
        news=news,
    )


def notes(day: Day) -> list[str]:
    """Notes on the day for a person, in sentences."""
    said = schedule.notes(schedule.schedule(ScheduleMode.TIMED, day.asked.every_s))
    said += attendance_notes(day)
    said += gap_notes(day)
    repeat = day.asked.repeat
    if day.reset_cycles:
        numbers = ", ".join(str(number) for number in day.reset_cycles)
        said.append(
            f"The machine halted in cycle {numbers}: a person looked at the patient and reset it. "
            "What was broken was not mended."
        )
    if len(day.cycles) < repeat and day.refusal is None:
        said.append(
            f"The day ended with cycle {len(day.cycles)} of {repeat}: it was broken off, and a "
            "halted machine, or one without its controller, waits for a person."
        )
    first, last = day.cycles[0].secretion_before_ml, day.left_ml
    if len(day.cycles) > 1 and last > first:
        said.append(
            f"Secretions gather faster than these cycles remove them: {first:.1f} mL at the "
            f"start, {last:.1f} mL at the end. Cycles would have to come more often, or a person "
            "clear what the tip does not reach."
        )
    return said


def summary(day: Day, reports: Sequence[CycleReport] = ()) -> DayResult:
    """Everything about a day. reports: of its cycles, where they were made."""
    news: list[CycleNews | None] = [cycle_news(report) for report in reports]
    found = DayResult(
        repeat=day.asked.repeat,
        every_min=day.asked.every_min or math.nan,
        cycles=tuple(
            _row(cycle, said)
            for cycle, said in zip(day.cycles, news or [None] * len(day.cycles), strict=True)
        ),
        produced_ml=day.produced_ml,
        removed_ml=sum(cycle.outcome.removed_ml for cycle in day.cycles),
        left_ml=day.left_ml,
        coughed_ml=day.coughed_ml,
        canister_ml=day.canister_ml,
        spo2_nadir_percent=float(np.min(day.samples.spo2_percent)),
        catheter_changes=sum(cycle.catheter_changed for cycle in day.cycles),
        assessments=sum(cycle.assessed for cycle in day.cycles),
        refusal=day.refusal,
        notes=tuple(notes(day)),
    )
    return measured(found)


def _gap(change: AdaptationChange | None) -> GapResult | None:
    """One cycle's change; None without self-calibration or after a broken cycle."""
    if change is None:
        return None
    seen = change.seen
    return GapResult(
        used_scale=change.old.scale,
        contact_scale=seen.contact_scale,
        mouth_scale=seen.mouth.scale,
        next_scale=change.new.scale,
        least_scale=change.limits.least,
        most_scale=change.limits.most,
        used_offset_mm=change.old.offset_mm,
        mouth_offset_mm=seen.mouth.offset_mm,
        next_offset_mm=change.new.offset_mm,
        usual_scale=change.course.usual,
        finding=name_of(change.finding),
        contact_spoilt=SPOILT[seen.spoilt] or None,
        mouth_missed=SENTENCES[seen.missed] or None,
        in_range=change.in_range,
    )


def gap_words(change: AdaptationChange | None) -> str:
    """Finding of a cycle on the gap, to be added to a line about it."""
    if change is None:
        return ""
    if change.finding == Finding.NOTHING_SEEN:
        return ", nothing to learn of the gap"
    if change.finding == Finding.CONTRADICTION:
        return ", contact and light barrier contradict each other on the gap"
    if change.finding == Finding.DOUBTED:
        return ", what was measured of the gap was dropped: one witness alone says it"
    scale, deeper_mm = change.found
    return f", gap {scale:.2f} x the identified one, tip {day_calibration.depth_words(deeper_mm)}"


def gap_alarms(day: Day, time_s: float | None) -> tuple[AlarmRecord, ...]:
    """The alarm that a refused gap is, for the last cycle. time_s: when it was found."""
    if day.refusal is None:
        return ()
    raised = Episode(
        condition=CONDITION,
        priority=CONDITION.row.handling.priority,
        started_s=math.nan if time_s is None else time_s,
        ended_s=None,
        latched=False,
        acknowledged_s=None,
    )
    return cycle_summary.alarms([raised])


def attendance_notes(day: Day) -> list[str]:
    """Actions at the bed without which the cycles would not have begun."""
    said = []
    given = [cycle.preoxygenation for cycle in day.cycles]
    for state in sorted(set(given) - {"not-required"}):
        said.append(f"Pre-oxygenation was {state} by a person before {given.count(state)} cycles.")
    looked = sum(cycle.assessed for cycle in day.cycles)
    if looked:
        most = day.last.loop.controller.service.passes.most_passes
        often = "once, after" if looked == 1 else f"{looked} times, each after"
        said.append(
            f"A person looked at the patient {often} {most} passes: without that the next cycle "
            "is refused."
        )
    return said


def gap_notes(day: Day) -> list[str]:
    """Unused measurements, the reason for which no further cycle began, and its remedy."""
    said = _unused_notes(day)
    if day.refusal is None:
        return said
    done, repeat = len(day.cycles), day.asked.repeat
    kept = f" Cycle {done + 1} of {repeat} was refused." if done < repeat else ""
    priority = CONDITION.row.handling.priority.name.lower()
    return [*said, f"Alarm ({priority}): {capitalise(day.refusal)}.{kept} {CONDITION.row.remedy}"]


def _unused_notes(day: Day) -> list[str]:
    """Cycles whose evidence was not used, and what a person should look at."""
    changes = {one.number: one.learned for one in day.cycles if one.learned is not None}
    said = []
    against = [n for n, one in changes.items() if one.finding == Finding.CONTRADICTION]
    if against:
        said.append(
            f"{_after(against)} contact and light barrier told different widths of the gap: "
            "neither was used. Look at both, unless the patient coughed or was moved."
        )
    doubted = [n for n, one in changes.items() if one.finding == Finding.DOUBTED]
    if doubted:
        said.append(
            f"{_after(doubted)} one witness alone told of a gap or a depth of the tip that no move "
            "of the patient explains: it was dropped, and would have been believed a second time."
        )
    for spoilt in Spoilt:
        numbers = [n for n, one in changes.items() if one.seen.spoilt == spoilt]
        if numbers and spoilt != Spoilt.NOTHING:
            said.append(f"{_after(numbers)} the contact told nothing of the gap: {SPOILT[spoilt]}.")
    for missed in Missed:
        numbers = [n for n, one in changes.items() if one.seen.missed == missed]
        if numbers and missed not in (Missed.NOTHING, Missed.NO_BARRIER):
            said.append(f"{_after(numbers)} nothing was learned at the mouth: {SENTENCES[missed]}.")
    return said


def _after(numbers: list[int]) -> str:
    return f"After cycle {', '.join(str(number) for number in numbers)}"
