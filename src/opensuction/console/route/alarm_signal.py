"""Sound and light of alarms: the machine's own figures, which the page follows.

The machine decides which alarm is signalled, and when (`GET /state`); this is only its form.
"""

from fastapi import APIRouter
from pydantic import BaseModel

from opensuction.safety.alarm import auditory_signal, visual_signal
from opensuction.safety.alarm.signal_value import HARMONIC_DB, HARMONICS
from opensuction.safety.priority import Priority

router = APIRouter(tags=["Machine"])


class PulseBody(BaseModel):
    """One tone of a burst, between its points at 90 %."""

    start_s: float
    end_s: float


class SignalBody(BaseModel):
    """Sound and light of a priority."""

    priority: str
    """``none``: the reminder's."""
    pulses: list[PulseBody]
    edge_s: float
    """Whole rise, and fall, of a pulse: half a cosine."""
    foot_s: float
    """Part of it that lies outside of the points at 90 %."""
    fundamental_hz: float
    harmonics: list[float]
    """Amplitudes of the fundamental and its harmonics; they add up to 1."""
    period_s: float
    """From the beginning of a burst to that of the next."""
    colour: str
    flash_hz: float
    """0: steady."""
    duty_ratio: float


def _signal(priority: Priority) -> SignalBody:
    tone, light = auditory_signal.TONES[priority], visual_signal.LIGHTS[priority]
    pulses = auditory_signal.pulses(priority)
    levels = [10.0 ** (HARMONIC_DB.value * order / 20.0) for order in range(int(HARMONICS.value))]
    edge_s = auditory_signal.edge_s(priority)
    return SignalBody(
        priority=priority.name.lower(),
        pulses=[PulseBody(**pulse._asdict()) for pulse in pulses],
        edge_s=edge_s,
        foot_s=auditory_signal.NINETY_PERCENT * edge_s,
        fundamental_hz=tone.fundamental_hz.value,
        harmonics=[level / sum(levels) for level in levels],
        period_s=pulses[-1].end_s + tone.interval_s.value,
        colour=light.colour,
        flash_hz=light.flash_hz.value,
        duty_ratio=light.duty_ratio.value,
    )


@router.get("/alarm-signals")
def list_alarm_signals() -> list[SignalBody]:
    """Sound and light of each priority, after IEC 60601-1-8."""
    return [_signal(priority) for priority in Priority]
