"""Alarms: which conditions are signalled, how urgently, and what a person has done about them.

Decided here and never in a user interface: a console that hangs or dies silences nothing. Time
comes in as the length of a tick. Terms after IEC 60601-1-8: an *alarm condition* is what is wrong,
an *alarm signal* is how people learn of it. Conditions are bits of a mask (`condition_mask`).

A condition that has held for its delay is *present*. A latching one stays *latched* when it ends,
until a person resets. *Acknowledged* conditions are shown but make no sound until they end; one
that begins again, or another, sounds. The *audio pause* silences everything for a limited time.
"""

from opensuction.kernel.compiled import compiled
from opensuction.safety.alarm import alarm_clock
from opensuction.safety.alarm.alarm_clock import DELAYED_MASK, RISING_MASK, Clocks, Seconds
from opensuction.safety.alarm.alarm_state import (
    AUDIBLE_S,
    LONGEST_PAUSE_S,
    NOTHING,
    SILENT,
    START,
    AlarmSettings,
    AlarmState,
    Buttons,
    Signals,
)
from opensuction.safety.condition_mask import (
    EVERY_BIT,
    HIGHS,
    LATCHING,
    LOWS,
    MEDIUMS,
    PLANNED,
    WORD,
)
from opensuction.safety.handling import HIGH, LOW, MEDIUM, NONE, Priority


@compiled
def _of_priority(conditions: int, escalated: int, priority: int) -> int:
    """Those of some conditions that have a priority, the raised ones counted one higher."""
    if priority == Priority.HIGH:
        return conditions & (HIGHS | (MEDIUMS & escalated))
    if priority == Priority.MEDIUM:
        return conditions & ((MEDIUMS & ~escalated) | (LOWS & escalated))
    return conditions & LOWS & ~escalated


@compiled
def most_urgent(conditions: int, escalated: int) -> int:
    """Highest priority in a mask of conditions, ``Priority.NONE`` in an empty one.

    escalated: mask of those that were raised by one priority.
    """
    if conditions == 0:
        return NONE
    for priority in (HIGH, MEDIUM):
        if _of_priority(conditions, escalated, priority) != 0:
            return priority
    return LOW


@compiled
def _first(shown: int, present: int, acknowledged: int, escalated: int) -> int:
    """Condition to show first: by priority, unanswered before answered, present before past."""
    chosen = _of_priority(shown, escalated, most_urgent(shown, escalated))
    if chosen & ~acknowledged != 0:
        chosen &= ~acknowledged
    if chosen & present != 0:
        chosen &= present
    for condition in range(WORD):
        if chosen >> condition & 1:
            return condition
    return NOTHING


@compiled
def _mature(state: AlarmState, holding: int, dt_s: float) -> tuple[int, int, Seconds]:
    """Masks of the conditions that are present and that wait, and the clocks of their delays."""
    present = holding & (state.present | ~DELAYED_MASK)
    delayed = holding & ~present
    if delayed == 0:
        return present, 0, state.clocks.held_s
    matured, held_s = alarm_clock.mature(state.clocks.held_s, delayed, state.waiting, dt_s)
    return present | matured, delayed & ~matured, held_s


@compiled
def _escalate(
    state: AlarmState, shown: int, begun: int, running: int, dt_s: float
) -> tuple[int, Seconds]:
    """Mask of the raised conditions, and how long each of those that may rise goes unanswered.

    shown: present or latched. begun: shown since this tick. running: those whose time runs.
    """
    escalated = state.escalated & shown
    if (begun | running) & RISING_MASK == 0:
        return escalated, state.clocks.unanswered_s
    raised, unanswered_s = alarm_clock.rise(state.clocks.unanswered_s, begun, running, dt_s)
    return escalated | raised, unanswered_s


@compiled
def _pause(
    settings: AlarmSettings, state: AlarmState, pressed: bool, loud: int, urgent: int, dt_s: float
) -> tuple[float, int, float]:
    """Remainder of the audio pause, what it silences, and the sound owed before another.

    loud: priority of what would sound now. urgent: priority of what is new in this tick.
    """
    left_s = state.pause_left_s - dt_s
    owed_s = max(state.owed_s - dt_s, 0.0)
    if loud == NONE:
        return 0.0, NONE, 0.0
    if state.pause_left_s > 0.0:
        broken = urgent == HIGH or urgent > state.paused_priority
        # Half a tick: sums of ticks are not exact, and a pause is never too long.
        if pressed or broken or left_s < 0.5 * dt_s:
            return 0.0, NONE, AUDIBLE_S
        return left_s, max(state.paused_priority, loud), owed_s
    if pressed and owed_s < 0.5 * dt_s and urgent == NONE:
        return min(settings.pause_s, LONGEST_PAUSE_S), loud, 0.0
    return 0.0, NONE, owed_s


@compiled
def _remind(
    settings: AlarmSettings, silent_s: float, shown: int, audible: int, dt_s: float
) -> tuple[float, bool]:
    """Time without sound of something shown since the last reminder; true where one is due."""
    if shown == 0 or audible != NONE:
        return 0.0, False
    silent_s += dt_s
    if silent_s + 0.5 * dt_s >= settings.reminder_s:
        return 0.0, True
    return silent_s, False


@compiled
def _advance(
    settings: AlarmSettings, state: AlarmState, holding: int, buttons: Buttons, dt_s: float
) -> tuple[AlarmState, Signals]:
    """A tick in which something holds or is shown, or was in the last."""
    present, waiting, held_s = _mature(state, holding, dt_s)
    new = present & ~state.present
    latched = (state.latched | (state.present & LATCHING)) & ~present
    if buttons.reset and not state.pressed.reset:
        latched = 0
    shown = present | latched
    # What begins in the very tick of the press was not seen by the person who pressed.
    acknowledged = state.acknowledged & shown & ~new
    if buttons.acknowledge and not state.pressed.acknowledge:
        acknowledged = shown & ~new
    running = 0 if state.pause_left_s > 0.0 else shown & ~acknowledged
    escalated, unanswered_s = _escalate(state, shown, new & ~state.latched, running, dt_s)
    loud = most_urgent(shown & ~acknowledged, escalated)
    urgent = most_urgent(new | (escalated & ~state.escalated), escalated)
    pressed = buttons.audio_pause and not state.pressed.audio_pause
    left_s, paused_priority, owed_s = _pause(settings, state, pressed, loud, urgent, dt_s)
    audible = NONE if left_s > 0.0 else loud
    silent_s, reminder = _remind(settings, state.silent_s, shown, audible, dt_s)
    following = AlarmState(
        present=present,
        latched=latched,
        acknowledged=acknowledged,
        escalated=escalated,
        waiting=waiting,
        clocks=Clocks(held_s, unanswered_s),
        pause_left_s=left_s,
        paused_priority=paused_priority,
        owed_s=owed_s,
        silent_s=silent_s,
        pressed=buttons,
    )
    signals = Signals(
        priority=most_urgent(shown, escalated),
        audible=audible,
        first=_first(shown, present, acknowledged, escalated),
        present=present,
        latched=latched,
        acknowledged=acknowledged,
        escalated=escalated,
        pause_left_s=left_s,
        reminder=reminder,
    )
    return following, signals


@compiled
def step(
    settings: AlarmSettings,
    state: AlarmState,
    conditions: int,
    planned_work: bool,
    buttons: Buttons,
    dt_s: float,
) -> tuple[AlarmState, Signals]:
    """Signals of one tick.

    conditions: bit mask of what is wrong now (bit ``Condition``); the governor's trips have the
    same numbers and are simply or-ed in. planned_work: a person has taken the machine out of
    service; what such work brings about raises no alarm. Nothing else can silence a condition:
    neither a console nor its absence is an argument.
    """
    holding = conditions & EVERY_BIT
    if planned_work:
        holding &= ~PLANNED
    if holding | state.present | state.latched == 0:
        return START._replace(clocks=state.clocks, pressed=buttons), SILENT
    return _advance(settings, state, holding, buttons, dt_s)
