"""The patient monitor's readings against the patient's limits, and how long each has been outside.

How long something must hold is chosen by how far the reading can be relied on. The saturation is
10 to 30 s old when it is shown [K]: in a cycle it can only tell of what began before, so waiting
2 s more for an artefact to pass costs nothing, and no abort relies on it alone. No blood falls by
`JUMP_PERCENT` between two values of a display that averages seconds: what leaps down is a hand that
moved, and is waited for. Heart rate (an average of seconds already) and airway pressure are what
act within a cycle. A cough raises the pressure for less than half a second, and more than one may
come; a breath of the patient's own lowers it for as long as it lasts.

The airway pressure is read at the connector, against the ventilator's settings: every breath must
cross a line just above PEEP, both ways. Suction that takes more than the ventilator gives empties
the lung, and the pressure falls below PEEP - 5 cmH2O [design]. After a cough it is as low as that,
for the cough has emptied the lung and suction takes most of what fills it, but it rises: as long as
it does, until the next breath, nothing is being lost. A lung that collapses below a high PEEP loses
volume where the pressure hardly falls: there the time below PEEP adds up. A circuit that has come
off leaves the connector at the pressure of the room, whatever is sucked: with more PEEP than
5 cmH2O volume is lost then too. A pressure that no breath moves is ventilation that fails, an
expiration that is blocked or a reading that is frozen.
"""

import math
from typing import NamedTuple

from opensuction.kernel.arithmetic import add_up_duration, extend_duration, flag
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Monitor
from opensuction.kernel.record import make_zero
from opensuction.safety.condition import Condition
from opensuction.safety.limits import SHAKEN_S, PatientLimits

SPO2_S = 2.0
"""How long the saturation must be low: four values of the display."""
HEART_RATE_S = 1.0
"""How long the heart rate must be low: it is an average of beats already."""
HIGH_FADE = 0.25
"""Share of the time without that is taken off: inspirations that are too high add up, coughs that
come seldom do not. Two thirds of a breath are expiration [design]."""
LOW_FADE = 0.5
"""The same of a pressure that is too low: expirations out of which suction takes add up over two
breaths, a breath of the patient's own each four seconds does not [computed]."""
DEEP_CMH2O = 4.0
"""Further below what is too low than a breath of a sedated patient's own pulls [assumed]."""
LOSING_MORE_S = 0.1
"""For how much longer the pressure may be on its way to too low; assumed."""
SINKING_LAG_S = 0.2
SINKING_CMH2O = 0.1
"""It falls where it is lower by so much than behind such a lag: .5 cmH2O/s, twice what a mean over
that lag leaves of a transducer's noise [computed]."""
FLUTTER_S = 0.1
"""A fall below the breaths' line that is shorter ends no breath: noise where it is crossed."""
RISEN_CMH2O = 0.25
"""By how much a pressure has risen from its lowest, beyond noise; assumed. After a cough an
adult's recoil from a PEEP of 6 rose by .3 in 1.5 s under suction: 80 mL were lost [in-silico]."""
JUMP_PERCENT = 4.0
"""Fall of the saturation between two values that no blood makes: at most 2 % in a second [assumed],
and the display averages several."""
ARTEFACT_S = 12.0
"""How long a leap down, or a saturation that is missing, is taken for a probe that slipped or a
hand that moved; assumed."""
LINK_S = 2.0
"""How long heart rate or pressure may be missing: a monitor repeats itself within a second."""
FILLED_S = 0.2
"""Within so long of the end of a fall the pressure of an inspiration crosses the breaths' line;
assumed."""
DEEP_SAG_CMH2O = 1.4
"""Depth below where the pressure sags, over all the time for which it may, of a fall that is told
of at once, as soon as it is no breath of the patient's own: 4.5 cmH2O s. No fall of 80 sound cycles
with ARDS came to more than 3.5; without any flow from the ventilator a patient with one of 6 lost
12 mL/kg in the next two breaths [in-silico]."""
SAG_CMH2O = 1.25
"""Depth below there of all falls that are suction's, over all the time for which they may last: as
long ones that are less deep take less. Of 360 drawn near the corners of the spread all 33 that lost
more than 11 mL/kg had 4.4 cmH2O s by then, and 1 of 410 sound cycles had 4 [in-silico]."""
ROOM_CMH2O = 1.0
"""Nearer than this to the atmosphere the connector may be open to the room."""


class Breath(NamedTuple):
    """The last breath or cough, as the pressure shows it."""

    raised: bool
    """On which side of the line the pressure was last."""
    lasted_s: float
    """For how long it is, or was, above it: a cough is shorter than any inspiration."""
    lowest_cmh2o: float
    """Lowest pressure since then."""


class Sag(NamedTuple):
    """Pressure that suction leaves below PEEP, since the valve was opened.

    A breath of the patient's own does so too. But what suction took the ventilator fills, and the
    next inspiration ends such a fall; a breath of one's own ends by itself.
    """

    in_all_s: float
    """Of falls that are known to be suction's."""
    in_all_cmh2o_s: float
    """How deep they were, over their time."""
    fall_s: float
    """Of the last one."""
    fall_cmh2o_s: float
    """How deep it was, over its time."""
    over_s: float
    """Since it ended."""


class PatientWatch(NamedTuple):
    """Watch on the patient: durations without a break, s; a missing value changes none."""

    spo2_percent: float
    """Saturation that was believed last; 0 before the first."""
    doubted_s: float
    """For how long another one has not been."""
    spo2_low_s: float
    heart_rate_low_s: float
    high_s: float
    low_s: float
    losing_s: float
    """Pressure on its way to too low."""
    lagged_cmh2o: float
    """Pressure behind a lag, from where it began to be on its way."""
    sinking_s: float
    """Pressure on its way to too low and falling still."""
    sag: Sag
    open_s: float
    """Connector at the room's pressure."""
    breath_s: float
    """Since the pressure last crossed the line."""
    breath: Breath
    missing_s: float
    """Since heart rate and pressure were there."""
    unsaturated_s: float
    """Since a saturation was there."""
    conditions: int
    """Bit mask of what holds now, of `condition.Condition`."""


NO_SAG = Sag(0.0, 0.0, 0.0, 0.0, 0.0)
UNSEEN = make_zero(PatientWatch)
"""At power-up."""


@compiled
def _extend(seconds: float, known: bool, holds: bool, dt_s: float) -> float:
    """As `duration.extend`; a value that is missing neither counts nor ends it."""
    return extend_duration(seconds, holds, dt_s) if known else seconds


@compiled
def _add_up(seconds: float, known: bool, holds: bool, fade: float, dt_s: float) -> float:
    """As `duration.add_up`; a value that is missing neither counts nor ends it."""
    return add_up_duration(seconds, holds, fade, dt_s) if known else seconds


@compiled
def _believe(
    watch: PatientWatch, known: bool, spo2_percent: float, dt_s: float
) -> tuple[float, float]:
    """The saturation that is believed, and for how long the one that is shown has not been."""
    if not known:
        return watch.spo2_percent, watch.doubted_s
    leapt = watch.spo2_percent - spo2_percent > JUMP_PERCENT
    if not leapt or watch.doubted_s > ARTEFACT_S:
        return spo2_percent, 0.0
    return watch.spo2_percent, watch.doubted_s + dt_s


@compiled
def _sink(
    limits: PatientLimits, watch: PatientWatch, known: bool, pressure: float, dt_s: float
) -> tuple[float, float]:
    """The pressure behind its lag, and for how long in all it has been falling below the line."""
    if not known:
        return watch.lagged_cmh2o, watch.sinking_s
    line = limits.airway_losing_cmh2o
    lagged = min(watch.lagged_cmh2o, line)
    lagged = line if pressure >= line else lagged + (pressure - lagged) * dt_s / SINKING_LAG_S
    sinking = pressure < lagged - SINKING_CMH2O and not abs(pressure) <= ROOM_CMH2O
    return lagged, add_up_duration(watch.sinking_s, sinking, LOW_FADE, dt_s)


@compiled
def _follow_sag(limits: PatientLimits, sag: Sag, pressure: float, dt_s: float) -> Sag:
    """Falls below PEEP after another tick of suction."""
    below = limits.airway_sagging_cmh2o - pressure
    if below > 0.0 and not abs(pressure) <= ROOM_CMH2O:
        return sag._replace(
            fall_s=sag.fall_s + dt_s, fall_cmh2o_s=sag.fall_cmh2o_s + below * dt_s, over_s=0.0
        )
    over_s = sag.over_s + dt_s
    is_filled = pressure > limits.breath_cmh2o
    if not is_filled and over_s <= FILLED_S:
        return sag._replace(over_s=over_s)
    if not (is_filled or sag.fall_s > limits.effort_s):
        return Sag(sag.in_all_s, sag.in_all_cmh2o_s, 0.0, 0.0, over_s)
    return Sag(sag.in_all_s + sag.fall_s, sag.in_all_cmh2o_s + sag.fall_cmh2o_s, 0.0, 0.0, over_s)


@compiled
def _has_sagged(limits: PatientLimits, sag: Sag) -> bool:
    """True where suction has left the pressure below PEEP for too long in all, or once too deep."""
    is_suction = sag.fall_s > limits.effort_s
    is_deep = is_suction and sag.fall_cmh2o_s > DEEP_SAG_CMH2O * limits.sagging_s
    lasted_s, depth_cmh2o_s = sag.in_all_s, sag.in_all_cmh2o_s
    if is_suction:
        lasted_s += sag.fall_s
        depth_cmh2o_s += sag.fall_cmh2o_s
    long = lasted_s > limits.sagging_s and depth_cmh2o_s > SAG_CMH2O * limits.sagging_s
    return long or is_deep


@compiled
def _follow_breath(
    limits: PatientLimits, watch: PatientWatch, known: bool, pressure: float, dt_s: float
) -> Breath:
    """The last breath or cough after another tick."""
    before = watch.breath
    if not known:
        return before
    if pressure <= limits.breath_cmh2o:
        return Breath(False, before.lasted_s, min(before.lowest_cmh2o, pressure))
    goes_on = before.raised or watch.breath_s < FLUTTER_S
    return Breath(True, before.lasted_s + dt_s if goes_on else dt_s, pressure)


@compiled
def _is_recoiling(limits: PatientLimits, breath: Breath, pressure: float) -> bool:
    """True where a cough has emptied the lung and it fills again: the pressure has risen since."""
    coughed = not breath.raised and 0.0 < breath.lasted_s < limits.cough_s
    return coughed and pressure > breath.lowest_cmh2o + RISEN_CMH2O


@compiled
def _find_conditions(limits: PatientLimits, watch: PatientWatch, sucking: bool) -> int:
    """Conditions that hold by how long each value has been outside; ``watch`` has those before."""
    losing = watch.losing_s > limits.low_s + LOSING_MORE_S or watch.sinking_s > limits.sinking_s
    going = losing or _has_sagged(limits, watch.sag)
    low = watch.low_s > limits.low_s or (going and sucking)
    # What suction took stays its doing while the valve closes.
    taken = sucking or watch.conditions >> Condition.LUNG_VOLUME_LOST & 1 == 1
    silent = watch.breath_s > limits.breath_s
    unsafe = watch.high_s > limits.cough_s or silent or (low and not taken)
    lost = watch.missing_s > LINK_S or watch.unsaturated_s > ARTEFACT_S
    return (
        flag(watch.spo2_low_s > SPO2_S, Condition.SPO2_LOW)
        | flag(watch.heart_rate_low_s > HEART_RATE_S, Condition.HEART_RATE_LOW)
        | flag(unsafe, Condition.AIRWAY_PRESSURE_UNSAFE)
        | flag(low and taken, Condition.LUNG_VOLUME_LOST)
        | flag(watch.open_s > limits.open_s, Condition.CIRCUIT_DISCONNECTED)
        | flag(lost, Condition.MONITOR_LINK_LOST)
    )


@compiled
def step(
    limits: PatientLimits, watch: PatientWatch, monitor: Monitor, sucking: bool, dt_s: float
) -> PatientWatch:
    """Bring what is known of the patient up to this tick.

    sucking: the valve is not known to be closed. A pressure that is too low is then volume that
    suction takes; with the valve closed it is the ventilation.
    """
    if not limits.monitored:
        return watch
    pressure = monitor.airway_pressure_cmh2o
    has_spo2 = monitor.connected and monitor.spo2_valid and math.isfinite(monitor.spo2_percent)
    has_rate = (
        monitor.connected and monitor.heart_rate_valid and math.isfinite(monitor.heart_rate_per_min)
    )
    has_pressure = monitor.connected and monitor.airway_pressure_valid and math.isfinite(pressure)
    breath = _follow_breath(limits, watch, has_pressure, pressure, dt_s)
    spo2, doubted_s = _believe(watch, has_spo2, monitor.spo2_percent, dt_s)
    believed = has_spo2 and doubted_s == 0.0
    spo2_low_s = _extend(watch.spo2_low_s, believed, spo2 < limits.spo2_percent, dt_s)
    slow = monitor.heart_rate_per_min < limits.heart_rate_per_min
    heart_rate_low_s = _extend(watch.heart_rate_low_s, has_rate, slow, dt_s)
    high_s = _add_up(
        watch.high_s, has_pressure, pressure > limits.airway_most_cmh2o, HIGH_FADE, dt_s
    )
    # Without suction nothing takes what fills it: then a pressure that stays low is a fault.
    recoiling = sucking and _is_recoiling(limits, breath, pressure)
    counts = has_pressure and not recoiling
    low_s = _add_up(watch.low_s, counts, pressure < limits.airway_least_cmh2o, LOW_FADE, dt_s)
    if counts and pressure < limits.airway_least_cmh2o - DEEP_CMH2O:
        # No breath of the patient's own goes so deep: as soon as of one who does not breathe.
        low_s += dt_s * (limits.low_s / SHAKEN_S - 1.0)
    losing = pressure < limits.airway_losing_cmh2o and not abs(pressure) <= ROOM_CMH2O
    losing_s = _add_up(watch.losing_s, counts, losing, LOW_FADE, dt_s)
    lagged_cmh2o, sinking_s = _sink(limits, watch, has_pressure, pressure, dt_s)
    sag = watch.sag if sucking else NO_SAG
    if sucking and has_pressure:
        sag = _follow_sag(limits, sag, pressure, dt_s)
    open_s = _extend(watch.open_s, has_pressure, abs(pressure) <= ROOM_CMH2O, dt_s)
    breath_s = _extend(watch.breath_s, has_pressure, breath.raised == watch.breath.raised, dt_s)
    missing_s = extend_duration(watch.missing_s, not (has_rate and has_pressure), dt_s)
    unsaturated_s = extend_duration(watch.unsaturated_s, not has_spo2, dt_s)
    now = PatientWatch(
        spo2_percent=spo2,
        doubted_s=doubted_s,
        spo2_low_s=spo2_low_s,
        heart_rate_low_s=heart_rate_low_s,
        high_s=high_s,
        low_s=low_s,
        losing_s=losing_s,
        lagged_cmh2o=lagged_cmh2o,
        sinking_s=sinking_s,
        sag=sag,
        open_s=open_s,
        breath_s=breath_s,
        breath=breath,
        missing_s=missing_s,
        unsaturated_s=unsaturated_s,
        conditions=watch.conditions,
    )
    return now._replace(conditions=_find_conditions(limits, now, sucking))


@compiled
def select_trips(conditions: int, inside: bool, entering: bool) -> int:
    """Those conditions that end a cycle, as a mask of trips.

    inside: the tip may be in the airway. entering: since this tick. Outside there is nothing to
    withdraw, and what is wrong is the monitor's affair. Values that stay away inside do not end a
    cycle (docs/decisions/0009): they only keep the catheter from going in.
    """
    if not inside:
        return 0
    if entering:
        return conditions
    return conditions & ~(1 << Condition.MONITOR_LINK_LOST)
