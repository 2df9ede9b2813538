"""Limits of what a patient's monitor may say, by age and by the ventilator's settings."""

from typing import Annotated, NamedTuple

from opensuction.kernel.age_group import AgeGroup
from opensuction.kernel.meaning import Meaning

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
