"""Alarms on their own: what is wrong and what is pressed, tick by tick, and what comes of it."""

from collections.abc import Iterable
from typing import Literal, NamedTuple

from hypothesis import strategies as st

from opensuction.safety.alarm import alarm, alarm_state
from opensuction.safety.alarm.alarm_state import AlarmState, Buttons, Signals
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode, encode
from tests.settled import settled

SETTINGS = alarm_state.check_settings(pause_s=120.0, reminder_s=60.0)
DT_S = 0.5
"""A long tick: minutes pass in a few hundred steps."""


class Tick(NamedTuple):
    """What goes in."""

    conditions: frozenset[Condition] = frozenset()
    acknowledge: bool = False
    audio_pause: bool = False
    reset: bool = False
    planned_work: bool = False


class Row(NamedTuple):
    """What comes out."""

    tick: Tick
    signals: Signals
    state: AlarmState

    @property
    def present(self) -> set[Condition]:
        return {Condition(bit) for bit in decode(self.signals.present)}

    @property
    def shown(self) -> set[Condition]:
        return {Condition(bit) for bit in decode(self.signals.present | self.signals.latched)}

    @property
    def acknowledged(self) -> set[Condition]:
        return {Condition(bit) for bit in decode(self.signals.acknowledged)}


step = settled(alarm.step)


def run(ticks: Iterable[Tick], dt_s: float = DT_S, state: AlarmState | None = None) -> list[Row]:
    """Signals of each tick, from power-up unless a state is given."""
    state = alarm_state.START if state is None else state
    rows = []
    for tick in ticks:
        buttons = Buttons(tick.acknowledge, tick.audio_pause, tick.reset)
        wrong = encode(set(tick.conditions))
        state, signals = step(SETTINGS, state, wrong, tick.planned_work, buttons, dt_s)
        rows.append(Row(tick, signals, state))
    return rows


def wrong(*conditions: Condition) -> Tick:
    """A tick in which these conditions hold and nobody presses anything."""
    return Tick(frozenset(conditions))


QUIET = Tick()
"""Nothing is wrong."""
SPO2 = wrong(Condition.SPO2_LOW)
"""A high alarm of the patient."""


def press(tick: Tick, name: Literal["acknowledge", "audio_pause", "reset"]) -> Tick:
    """The same tick, in which somebody presses this."""
    return Tick(
        tick.conditions,
        acknowledge=name == "acknowledge",
        audio_pause=name == "audio_pause",
        reset=name == "reset",
    )


def lasting(tick: Tick, seconds: float, dt_s: float = DT_S) -> list[Tick]:
    """The same tick over and over."""
    return [tick] * round(seconds / dt_s)


@st.composite
def histories(draw: st.DrawFn, most: int = 8, planned: bool = False) -> list[Tick]:
    """Ticks in stretches: some conditions hold, with buttons pressed or held down."""
    history: list[Tick] = []
    for _ in range(draw(st.integers(1, most))):
        tick = Tick(
            conditions=frozenset(draw(st.sets(st.sampled_from(Condition), max_size=3))),
            acknowledge=draw(st.booleans()),
            audio_pause=draw(st.booleans()),
            reset=draw(st.booleans()),
            planned_work=draw(st.booleans()) if planned else False,
        )
        idle = tick._replace(acknowledge=False, audio_pause=False, reset=False)
        held = draw(st.sampled_from((1, 2, 40, 250)))
        history += [tick] * held + [idle] * draw(st.sampled_from((0, 1, 7, 130, 260)))
    return history
