"""The limits of one patient on one machine.

Limits of what a patient's monitor may say, by age and by the ventilator's settings.

Deepest and shallowest possible position of the tip; there is no tip sensor.

Between the head and the tip lies a gap whose width is known only between two bounds. Behind a gap
of width w the catheter follows the head as ``p = min(max(p, head - w/2), head + w/2)``; the
interval that is kept here holds p for every w between the bounds, also one that changes on the way.

Upper bound of the head's position by the commands so far; a head beyond it runs away.
"""

from typing import Annotated, NamedTuple

from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Setpoints
from opensuction.kernel.vocabulary import AgeGroup, Meaning


class AdvanceBound(NamedTuple):
    """Bound on the head's depth, and on the speed with which it may still go deeper."""

    head_mm: float
    """Raised by the command and the braking distance beyond it, lowered again by the reading."""
    coast_mm_per_s: float
    """Speed inwards that a head may still have after its command has stopped."""


@compiled
def step(
    braking_mm_per_s2: float,
    found_mm_per_s: float,
    state: AdvanceBound,
    last: Setpoints,
    head_mm: float,
    jumped_mm: float,
    unseen: bool,
    dt_s: float,
) -> AdvanceBound:
    """Bring it up to this tick.

    found_mm_per_s: speed inwards that the head is found with. last: what was let through in the
    last tick. jumped_mm: how far the head is from where it was
    thought to be, other than it can have travelled. unseen: it may have moved without a reading.
    Where it is found then is taken for granted.
    """
    braked_mm_per_s = state.coast_mm_per_s - braking_mm_per_s2 * dt_s
    coast_mm_per_s = max(braked_mm_per_s, last.head_mm_per_s, found_mm_per_s)
    allowed_mm = max(state.head_mm + max(jumped_mm, 0.0) + coast_mm_per_s * dt_s, last.head_mm)
    if unseen:
        return AdvanceBound(head_mm, coast_mm_per_s)
    return AdvanceBound(min(allowed_mm, head_mm), coast_mm_per_s)


GAP_LEAST = 0.7
"""Share of the identified gap that it may have shrunk to before the bound fails."""
GAP_MOST = 1.3
"""Share of the identified gap that it may have grown to."""


class TipBounds(NamedTuple):
    """Bounds on the tip's lead and lag against the head."""

    gain: float
    """Tip travel for each mm of head travel."""
    offset_mm: float
    narrow_mm: float
    """Head travel across the narrowest gap thought possible."""
    wide_mm: float


class TipInterval(NamedTuple):
    """Interval of the catheter behind the gap, in head travel."""

    foremost_mm: float
    rearmost_mm: float


def bound_tip(gain: float, offset_mm: float, gap_mm: float) -> TipBounds:
    """Bounds around an identified (or nominal) gap of the transmission.

    gap_mm: full width, mm of tip between the advancing and the retracting branch.
    """
    return TipBounds(
        gain=gain,
        offset_mm=offset_mm,
        narrow_mm=GAP_LEAST * gap_mm / gain,
        wide_mm=GAP_MOST * gap_mm / gain,
    )


@compiled
def assume_anywhere(bounds: TipBounds, head_mm: float) -> TipInterval:
    """Interval when nothing is known of how the head came here: after a retract, or an advance."""
    return TipInterval(
        foremost_mm=head_mm + 0.5 * bounds.wide_mm, rearmost_mm=head_mm - 0.5 * bounds.wide_mm
    )


@compiled
def follow(bounds: TipBounds, interval: TipInterval, head_mm: float) -> TipInterval:
    """Interval once the head has been measured at ``head_mm``.

    Foremost: pushing in, the narrowest gap brings the catheter furthest; drawing out, the widest
    holds it longest. Rearmost: the mirror image. The plays of the two extreme widths alone do not
    bound those between them: after a reversal a middle gap is the last to follow.
    """
    narrow_mm, wide_mm = 0.5 * bounds.narrow_mm, 0.5 * bounds.wide_mm
    return TipInterval(
        foremost_mm=min(max(interval.foremost_mm, head_mm - narrow_mm), head_mm + wide_mm),
        rearmost_mm=min(max(interval.rearmost_mm, head_mm - wide_mm), head_mm + narrow_mm),
    )


@compiled
def deepest_mm(bounds: TipBounds, interval: TipInterval) -> float:
    """Deepest tip position that is possible."""
    return bounds.gain * interval.foremost_mm + bounds.offset_mm


@compiled
def shallowest_mm(bounds: TipBounds, interval: TipInterval) -> float:
    """Shallowest tip position that is possible."""
    return bounds.gain * interval.rearmost_mm + bounds.offset_mm


@compiled
def head_cap_mm(bounds: TipBounds, cap_mm: float) -> float:
    """Head position beyond which an advance could take the tip past the cap."""
    return (cap_mm - bounds.offset_mm) / bounds.gain + 0.5 * bounds.narrow_mm


LOST_CMH2O = 5.0
"""Pressure below PEEP at which lung volume is being lost [design-lung]."""
LOSING_CMH2O = 3.5
"""And at which it begins to be: a breath later it is as low in a stiff lung. No sound cycle came
there, of 192 on four patients, by both approaches [in-silico]."""
SAGGING_CMH2O = 1.0
"""Pressure below PEEP at which a lung that collapses below it may be losing volume."""
SAGGING_S = 3.2
"""Time in all for which a suction may leave it there. Of 463 drawn patients with ARDS one had more;
of 331 at the corners of their spread all 33 that lost more than 11 mL/kg did [in-silico]."""
NO_SUCTION_S = 3600.0
"""No suction is as long: of a lung that holds its volume this is not asked."""
COLLAPSING_CMH2O = 10.0
"""Who needs as much PEEP has such a lung; assumed."""
TRANSDUCER_CMH2O = 0.2
"""Error of the pressure that is no loss; assumed."""
SHAKEN_S = 0.3
"""A stroke of the valve shakes the pressure for less; assumed."""
BREATH_CMH2O = 2.0
"""Above PEEP by this lies the line that each breath crosses."""
LEAST_PEEP_CMH2O = 3.0
"""With less PEEP an expiration looks like a circuit that is open to the room."""
OPEN_S = 1.0
"""How long the connector must be at the room's pressure to count as open; with little PEEP longer
than an expiration: as long as a breath may take. Suction that empties the lung passes through it in
half a second; assumed."""


SINKING_SHARE = 0.75
"""Share of the longest breath of a patient's own for which the pressure may go on falling where
volume begins to be lost: a breath, or the recoil after a cough, falls for half of its time and
comes back; a lung that empties falls until the ventilator fills it again [computed]."""
SINKING_S = 0.7
"""For so long a pull that begins at once and stays, 3 cmH2O deep, looks as if it went on falling
[computed]: of shorter breaths nothing is told sooner."""


class AgeLimits(NamedTuple):
    """Limits of a patient by age; sources in `SOURCES`."""

    spo2_percent: Annotated[float, Meaning("lowest saturation, as the oximeter shows it")]
    heart_rate_per_min: Annotated[float, Meaning("lowest heart rate")]
    airway_most_cmh2o: Annotated[float, Meaning("highest pressure at the connector")]
    breath_s: Annotated[float, Meaning("longest time in which no breath moves the pressure")]
    effort_s: Annotated[float, Meaning("longest breath of the patient's own")]
    cough_s: Annotated[float, Meaning("time in all for which coughs may raise the pressure")]


AGE_LIMITS: dict[AgeGroup, AgeLimits] = {
    AgeGroup.NEONATE: AgeLimits(80.0, 100.0, 30.0, 4.0, 0.4, 0.3),
    AgeGroup.CHILD: AgeLimits(80.0, 80.0, 35.0, 6.0, 0.6, 0.35),
    AgeGroup.ADULT: AgeLimits(80.0, 50.0, 40.0, 10.0, 1.2, 0.6),
}
"""Limits by age group."""

SOURCES: dict[str, str] = {
    "spo2_percent": "[assumed] 88, the least aimed at in acute lung injury [K], less 5 that "
    "suction may take [Simarmata-2019] and 3 of the oximeter [K]",
    "heart_rate_per_min": "bradycardia by age [K]",
    "airway_most_cmh2o": "usual upper alarm limit of ventilators [assumed]",
    "breath_s": "[assumed] apnoea alarms wait for 10 to 20 s [K]; sooner with small stores of "
    "oxygen",
    "effort_s": "[assumed] an inspiration of 0.35, 0.5 and 1 s, and a fifth",
    "cough_s": "[assumed] a cough pushes for 0.2, 0.25 and 0.3 s, not all of it above the limit; "
    "an adult coughs twice",
}
"""Where each limit comes from."""


class PatientLimits(NamedTuple):
    """The limits of one patient."""

    spo2_percent: float
    heart_rate_per_min: float
    airway_most_cmh2o: float
    breath_s: float
    effort_s: float
    cough_s: float
    """These and what is before them: `AgeLimits`."""
    monitored: bool
    """Whether a monitor belongs to the machine: without one nothing here is judged."""
    airway_least_cmh2o: float
    """Below it lung volume is being lost."""
    airway_losing_cmh2o: float
    """Below it for longer, with the valve open, too."""
    airway_sagging_cmh2o: float
    """Below it for `sagging_s` in all of a suction, too."""
    breath_cmh2o: float
    """Every breath crosses it twice."""
    open_s: float
    low_s: float
    """How long the pressure must be too low."""
    sinking_s: float
    """How long it must be falling towards that, under suction."""
    sagging_s: float
    """How long in all of a suction it may sag."""


def limits_of(
    age: AgeGroup, peep_cmh2o: float, monitored: bool, breathes: bool = False
) -> PatientLimits:
    """Limits for a patient of an age on a ventilator set to this PEEP.

    breathes: on their own, besides the ventilator.
    """
    chosen = AGE_LIMITS[age]
    low_s = chosen.effort_s if breathes else SHAKEN_S
    return PatientLimits(
        *chosen,
        monitored=monitored,
        airway_least_cmh2o=peep_cmh2o - LOST_CMH2O - TRANSDUCER_CMH2O,
        airway_losing_cmh2o=peep_cmh2o - LOSING_CMH2O - TRANSDUCER_CMH2O,
        airway_sagging_cmh2o=peep_cmh2o - SAGGING_CMH2O,
        breath_cmh2o=peep_cmh2o + BREATH_CMH2O,
        open_s=OPEN_S if peep_cmh2o >= LEAST_PEEP_CMH2O else chosen.breath_s,
        low_s=low_s,
        sinking_s=max(SINKING_SHARE * low_s, SINKING_S),
        sagging_s=SAGGING_S if peep_cmh2o >= COLLAPSING_CMH2O else NO_SUCTION_S,
    )


class DriveLimits(NamedTuple):
    """Force of the insertion motor for its current, and the limits of that force."""

    newton_per_a: float
    """Force at the head for each ampere."""
    moving_mass_kg: float
    """Inertia of the drive, referred to the head."""
    jam_n: float
    """Resistance that no friction explains: something holds the catheter."""
    force_n: float
    """Force that the drive's own current limit never lets through."""
    supply_v: float
    mm_per_s_per_v: float
    """Speed of the head without load for each volt on the motor."""
    volts_per_a: float
    """Volts that drive an ampere through the motor at standstill."""
    gaining_least_mm_per_s2: float
    """Least gain of speed at the drive's current limit."""
    gaining_most_mm_per_s2: float
    """Fastest change of speed that the drive can bring about, friction helping."""


class WindowLimits(NamedTuple):
    """Window in which the tip may and must touch: see `opensuction.safety.watch.tip_force`."""

    from_mm: float
    """A tip that is nowhere deeper has nothing to touch."""
    by_mm: float
    """A tip that is everywhere deeper has passed the carina; infinite where it stops by travel."""


class ValveLimits(NamedTuple):
    """The valve's cam."""

    open_rad: float
    stroke_s: float
    """Planned duration of a stroke."""


class LineLimits(NamedTuple):
    """Limits of a sound suction line: see `opensuction.safety.watch.vacuum_signature`."""

    open_low_share: float
    """Share of the set point that it keeps at least with the valve open."""
    clogged_share: float
    """Share that it falls below with the valve open; infinite where the flow is too small."""
    rests_open: bool
    """The pump rests with the valve open, too, until the vacuum has fallen: a flow that a running
    pump hides shows then."""
    open_fall_mmhg_per_s: float
    """Steepest fall when the valve opens, the pump running."""
    bore_fall_mmhg_per_s: float
    """And with the pump at a standstill."""
    bore_fall_mmhg_per_s_per_root: float
    """The same for each root of the vacuum in mmHg, whatever the set point."""
    parked_closed_mmhg: float
    """Highest vacuum behind a closed valve with the tip parked, to test the relief valve."""


class Limits(NamedTuple):
    """Limits of the governor. Every value is set for the patient; none has a default."""

    tip: TipBounds
    drive: DriveLimits
    window: WindowLimits
    valve: ValveLimits
    line: LineLimits
    cap_mm: float
    """Deepest tip position ever allowed."""
    outside_mm: float
    """The deepest possible tip is above this: it is out of the patient."""
    mouth_mm: float
    """Where the light barrier is; infinite where there is none."""
    park_head_mm: float
    head_speed_mm_per_s: float
    head_mm_per_s2: float
    """Fastest gain of commanded head speed; a stop may be as sudden as it must."""
    braking_mm_per_s2: float
    """Slowest braking of a head that is told to stop."""
    leaving_mm_per_s: float
    """Speed at which the slowest such head withdraws."""
    following_mm: float
    """Largest distance between commanded and measured head."""
    stalled_mm: float
    """Distance from its command at which the servo must be moving the head, whatever friction."""
    vacuum_mmhg: float
    """Highest line vacuum."""
    negative_pressure_s: float
    in_airway_s: float
    contact_s: float
    driven_contact_s: float
    """Longest contact while the drive holds the head, and no hand moves it."""
    withdrawal_s: float
    """Longest time a forced withdrawal may take before torque is cut."""
    patient: PatientLimits
