"""Allowances of single faults on the bounds of a run, each with its reason.

Some faults do harm before any sensor can show them, or leave no actuator that could prevent it. For
these a bound is raised by the amount that physics makes unavoidable, as a number; the raised bound
is checked in the same way as the common one is for all other faults. Some faults are a harm by
themselves: a patient whose circuit has come off is without pressure, whatever a suction machine
does.

An allowance is not part of a fault's row: the rows describe effects on the machine, in the twin; a
bound describes what a patient may bear, and belongs to the judgement of a trace.
"""

import math
from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple

from opensuction.oracle.harm import (
    ADVANCE,
    AIRWAY_PRESSURE,
    AIRWAY_TIME,
    CONTACT_TIME,
    FORCE,
    LUNG_VOLUME,
    SATURATION,
    SUCTION_TIME,
    TIP_PAST_CAP,
    Harm,
)
from opensuction.simulation.injection.fault_instant import Injection
from opensuction.twin.fault.fault import Fault


class Allowance(NamedTuple):
    """Allowance that a fault adds to a bound."""

    fault: Fault
    bound: str
    """Name of the harm."""
    more: float
    """On top of the common bound, in its unit."""
    reason: str
    for_strength: bool = False
    """As much again as the fault's own strength, which is in the bound's unit."""
    up_to: float = math.inf
    """Strength beyond which the fault adds nothing: it is told in time."""
    over_strength: float = math.inf
    """No more than ``least`` and so much over the strength: a stronger fault shows sooner."""
    least: float = 0.0


class OwnHarm(NamedTuple):
    """Harm that a fault of the patient, or of the ventilator, does by itself."""

    fault: Fault
    bounds: tuple[str, ...]
    reason: str


MOST_MM = 100.0
"""A bound of more cannot be broken: no patient's airway is so long beyond it."""
REROUTED_N = 0.25
"""The catheter is pushed on by 9 mm at once: it buckles at 0.35 N at most (a neonate's short free
end; 0.2 N in an adult) and then adds 5 % of 0.1 N/mm (0.3): 0.43 N; the patient's and catheter's
spread on top [computed]."""
LIFTED_CARINA_N = 0.9
"""The carina itself comes up against a catheter that stands still: 60 mm of it are 0.2 N to buckle
and 5 % of 0.3 N/mm over the rest, 1.1 N in an adult [computed]. It is over when the catheter has
come out of it, and that begins with contact."""
UNFELT_S = 12.0
"""The carina comes up to the tip and touches it with less than closes its switch: for the rest of
an adult's suction of 15 s at most, of which no sensor tells."""
WIDE_S = 1.0
"""The bound's 1 s is the way across a gap of 26 mm at 30 mm/s; one three times as wide as was
identified takes as much again [computed]."""
REROUTED_MM = 9.0
"""A conduit that is moved within a cycle moves the catheter in it: by half of a gap of 26 mm at
most, narrowed to 0.3 of it [computed]."""
CAP_MARGIN_MM = 5.0
"""The cap is at least so far beyond where a cycle stops [design]."""
COAST_MM = 1.2
"""A drive that pushes the wrong way is detected by its travel, and then coasts against friction
alone: 1.7 mm in all with detection after 1 mm [in-silico]; it is 0.3 mm now."""
UNDETECTED_JUMP_MM = 1.0
"""A jump of the reading shows as speed, averaged over 10 ms: one of 0.85 mm or less stays below
1.25 times the fastest 62 mm/s, and the servo follows it [computed]; its overshoot on top."""
UNNOTICED_WAY_MM = 60.0
"""An adult's tip makes 60 mm in the 2 s until the line shows it, at 30 mm/s in the tube; a small
patient's whole way is 42 mm of tube and 16 mm to the carina [computed]. Under no more than the 10
mmHg that the line has on the way in."""
OPEN_WAY_MM = 6.0
SLIT_WAY_MM = 7.5
"""A slide that is wholly open shows within 12.3 mm of a small patient's way under 10 mmHg. One that
is open by less takes the line's vacuum more slowly, and draws with less: 27 mm under 4.5 mmHg at
.3, 41 under 3 at a fifth (six to eight machines of each kind, from before the insertion to its end
[in-silico])."""
SLIT_SHARE = 0.2
"""Opening of a slide up to which a thin catheter draws less than a resting line may lose: 6 % give
5 mmHg at a neonate's tip [in-silico]."""
UNNOTICED_S = 4.3
"""A small patient's longest way in, by contact and back off the carina, before the valve is opened:
64 drawn machines [in-silico]."""
COUGHED_MM = 22.5
"""A trachea shortens by 9 mm at 60 cmH2O: at the strongest cough of 150 it takes a tip that lies on
the carina so far along, and gives it back [computed]."""
MISSED_MM = 17.0
"""Approach by contact: the way from the carina to the end of its search, 8 mm and the margin of the
cap, and what was taught too deep [computed]."""

ADRIFT_SUCKING_MM = 10.0
"""A zero that both sensors of the head have in common drifts, and the servo follows it: 0.67 mm/s,
which the motor does not tell yet, for 15 s of suction [computed]."""
ADRIFT_CAP_MM = 6.5
"""The same before the cap: 5 mm/s for the 1.3 s until the motor tells it [computed]."""

ALLOWANCES: tuple[Allowance, ...] = (
    Allowance(
        Fault.TUBE_DISPLACED,
        FORCE,
        LIFTED_CARINA_N,
        "the fault itself moves the carina into the tip, faster than any drive",
    ),
    Allowance(
        Fault.TUBE_DISPLACED,
        CONTACT_TIME,
        UNFELT_S,
        "as its force, where that is too little to close the switch",
    ),
    Allowance(
        Fault.CONDUIT_REROUTED,
        CONTACT_TIME,
        WIDE_S,
        "the head must cross the gap, however wide it has become, before the tip comes",
    ),
    Allowance(
        Fault.CONDUIT_REROUTED,
        FORCE,
        REROUTED_N,
        "moving the conduit pushes the catheter on before anything can be read of it",
    ),
    Allowance(
        Fault.CONDUIT_REROUTED,
        ADVANCE,
        REROUTED_MM,
        "as its force: no command moves the tip",
    ),
    Allowance(
        Fault.CONDUIT_REROUTED,
        TIP_PAST_CAP,
        REROUTED_MM - CAP_MARGIN_MM,
        "as its force; the cap allows for gaps of 0.7 to 1.3 of the identified one",
    ),
    Allowance(
        Fault.MOTOR_REVERSED,
        ADVANCE,
        COAST_MM,
        "the head must move before its encoder shows it, and coasts when its torque is off",
    ),
    Allowance(
        Fault.ENCODER_OFFSET,
        ADVANCE,
        UNDETECTED_JUMP_MM,
        "a small jump cannot be told from motion, and the servo corrects it",
    ),
    Allowance(
        Fault.ENCODER_JUMPING,
        ADVANCE,
        UNDETECTED_JUMP_MM,
        "as an offset; larger jumps show as speed",
    ),
    Allowance(
        Fault.VALVE_STUCK_OPEN,
        ADVANCE,
        UNNOTICED_WAY_MM,
        "a slide that leaves its seat by itself shows in the vacuum of the resting line within a "
        "second or two; through a thin catheter, open by less than a fifth, or where mucus blocks "
        "it, not before the next pre-use test, and the insertion goes on",
        over_strength=SLIT_WAY_MM,
        least=OPEN_WAY_MM,
    ),
    Allowance(
        Fault.VALVE_STUCK_OPEN,
        SUCTION_TIME,
        UNNOTICED_S,
        "as its advance; what a slit draws on the way in counts as suction, from 1 mmHg on",
        up_to=SLIT_SHARE,
    ),
    Allowance(
        Fault.HEAD_SENSORS_DRIFTING,
        ADVANCE,
        ADRIFT_SUCKING_MM,
        "what both sensors say together is told from the truth by the motor alone, from 0.7 mm/s "
        "on, and by the light barrier once the head is home",
    ),
    Allowance(
        Fault.HEAD_SENSORS_DRIFTING,
        TIP_PAST_CAP,
        ADRIFT_CAP_MM,
        "as its advance",
    ),
    Allowance(
        Fault.COUGH,
        FORCE,
        LIFTED_CARINA_N,
        "as a tube that is displaced: the patient moves the carina into the tip",
    ),
    Allowance(
        Fault.COUGH,
        ADVANCE,
        COUGHED_MM,
        "as its force: the patient moves the tip, and no command",
    ),
    Allowance(
        Fault.CARINA_MISSED,
        TIP_PAST_CAP,
        MISSED_MM,
        "that the carina was missed is known when it has not been met where it must be",
    ),
    Allowance(
        Fault.MOTOR_INTERMITTENT,
        CONTACT_TIME,
        0.0,
        "a tip on the carina stays there while the motor is without current: as long as that is",
        for_strength=True,
    ),
    Allowance(
        Fault.MOTOR_INTERMITTENT,
        AIRWAY_TIME,
        0.0,
        "as its contact; a motor that is back brings the catheter out at once",
        for_strength=True,
    ),
)

OWN_HARM: tuple[OwnHarm, ...] = (
    OwnHarm(
        Fault.CIRCUIT_DISCONNECTED,
        (AIRWAY_PRESSURE, LUNG_VOLUME, SATURATION),
        "an open circuit is without pressure until a person closes it",
    ),
    OwnHarm(
        Fault.VENTILATOR_PRESSURE,
        (AIRWAY_PRESSURE, LUNG_VOLUME, SATURATION),
        "the ventilator gives the wrong pressure until a person mends that",
    ),
    OwnHarm(
        Fault.DECANNULATION,
        (AIRWAY_PRESSURE, LUNG_VOLUME, SATURATION),
        "a tube that has come out leaves the patient without pressure until a person helps",
    ),
    OwnHarm(
        Fault.COUGH,
        (AIRWAY_PRESSURE, LUNG_VOLUME),
        "a cough is a high pressure, and the breath that follows it a low one",
    ),
    OwnHarm(Fault.DESATURATION, (SATURATION,), "the saturation falls for the patient's reasons"),
)


def _find_more(name: str, strengths: Mapping[Fault, float], strictly: Collection[str]) -> float:
    """Largest allowance of any fault on a bound, in its unit. Infinite for their own harm."""
    if any(one.fault in strengths and name in one.bounds for one in OWN_HARM):
        return math.inf
    if name in strictly:
        return 0.0
    more = [
        _of_strength(one, strengths[one.fault])
        for one in ALLOWANCES
        if one.bound == name and one.fault in strengths and strengths[one.fault] <= one.up_to
    ]
    return max(more, default=0.0)


def _of_strength(one: Allowance, strength: float) -> float:
    """Allowance of a fault of a strength."""
    if math.isfinite(one.over_strength):
        return min(one.more, one.least + one.over_strength / strength)
    return one.more + (strength if one.for_strength else 0.0)


def _strengths_of(came: Iterable[Injection]) -> dict[Fault, float]:
    """The greatest strength of each fault."""
    strengths: dict[Fault, float] = {}
    for one in came:
        strengths[one.fault] = max(one.strength, strengths.get(one.fault, 0.0))
    return strengths


def raise_limits(
    found: Iterable[Harm], came: Iterable[Injection], strictly: Collection[str] = ()
) -> tuple[Harm, ...]:
    """The same bounds, each by so much higher as the faults make unavoidable.

    Arguments as of `find_breaches`. The bound of a saturation is lower then.
    """
    strengths = _strengths_of(came)
    raised = []
    for one in found:
        more = _find_more(one.name, strengths, strictly)
        raised.append(one._replace(limit=one.limit + (-more if one.name == SATURATION else more)))
    return tuple(raised)


def find_breaches(
    found: Iterable[Harm], came: Iterable[Injection], strictly: Collection[str] = ()
) -> tuple[Harm, ...]:
    """Harm that goes beyond what the faults make unavoidable; of two the one that adds most counts.

    came: the faults whose instant came. strictly: names of bounds to which nothing is added.
    """
    strengths = _strengths_of(came)
    return tuple(
        one
        for one in found
        if abs(one.worst - one.limit) > _find_more(one.name, strengths, strictly)
    )
