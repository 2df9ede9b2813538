"""The limits of one patient on one machine."""

from typing import NamedTuple

from opensuction.safety.patient_limit import PatientLimits
from opensuction.safety.tip_bound import TipBounds


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
    """Window in which the tip may and must touch: see `opensuction.safety.watch.contact_window`."""

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
