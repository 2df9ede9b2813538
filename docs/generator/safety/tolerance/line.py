"""Thresholds of the governor on the suction line's vacuum."""

import math
from typing import NamedTuple

from docs.generator.safety.tolerance.noise import Filter, low_pass, rate
from docs.generator.safety.tolerance.sensor_error import Errors, least, most, spread
from docs.generator.safety.tolerance.threshold import Borne, Chance, Constant, Threshold
from opensuction.controller.governor_limit import OPEN_LOW_SHARE, VACUUM_MARGIN, line_limits
from opensuction.controller.machine_profile import CLINICAL as PROFILE
from opensuction.kernel.unit import ATMOSPHERE_MMHG, ML_PER_S
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.procedure.cycle import progress
from opensuction.procedure.planning.clinical import ADULT, PAEDIATRIC
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.procedure.planning.planner import WAY_IN_MMHG
from opensuction.safety.governor.judgement import PERSISTENCE_S
from opensuction.safety.watch import vacuum_signature
from opensuction.twin.fault.fault import Fault
from opensuction.twin.machine.catheter import BY_AGE_GROUP, CATHETERS
from opensuction.twin.parameter import CLINICAL, SPREAD_LIMIT
from opensuction.twin.sensor.sensor import DRIFT_S

LEAST_SET = PAEDIATRIC.vacuum_mmhg[AgeGroup.NEONATE]
"""A neonate's set point, the lowest: a share of it is least there."""
CHILD_SET = PAEDIATRIC.vacuum_mmhg[AgeGroup.CHILD]
SET = ADULT.vacuum_mmhg[AgeGroup.ADULT]
MOST_IN = WAY_IN_MMHG[AgeGroup.ADULT]
SINCE_VENTED_S = 60.0
"""From the vented line of the pre-use test to the end of a cycle, at most; assumed."""
WATCH = "safety.watch.vacuum_signature"
SENSOR = (
    "vacuum_noise_mmhg",
    "vacuum_offset_mmhg",
    "vacuum_drift_mmhg",
    "vacuum_gain",
    "vacuum_step_mmhg",
)
SMOOTH = low_pass(vacuum_signature.FILTER_S)
SLOW = low_pass(vacuum_signature.FILTER_S, vacuum_signature.RATE_S)
RATE = rate(vacuum_signature.FILTER_S, vacuum_signature.RATE_S)
LEARNT = low_pass(vacuum_signature.FILTER_S, vacuum_signature.ZERO_S)


def offset_left(errors: Errors) -> float:
    """Offset that is left once it was learnt: what wandered since, and the noise in it."""
    offset, drift = errors["vacuum_offset_mmhg"], errors["vacuum_drift_mmhg"]
    if offset + drift > vacuum_signature.ZERO_MMHG:
        return offset + drift
    wandered = math.sqrt(2.0 * (1.0 - math.exp(-SINCE_VENTED_S / DRIFT_S)))
    learnt = LEARNT.ratio * errors["vacuum_noise_mmhg"]
    return SPREAD_LIMIT * (drift * wandered + learnt)


def reading(errors: Errors, level: float, beyond: float = 0.0, behind: Filter = SMOOTH) -> Borne:
    """What is read other than the level, of a line that is that much beyond it itself."""
    error = offset_left(errors) + errors["vacuum_gain"] * level
    return Borne(
        static=error + 0.5 * errors["vacuum_step_mmhg"] + beyond,
        sigma=behind.ratio * errors["vacuum_noise_mmhg"],
    )


def pumped(level: float) -> float:
    """Most that a pump draws at a vacuum, mL/s."""
    return most("pump_free_l_per_min") * ML_PER_S * (1.0 - level / most("pump_occluded_mmhg"))


def over_set(level: float) -> float:
    """By how much the weakest regulator lets the strongest pump raise the line, mmHg."""
    return pumped(level) / least("regulator_ml_per_s_per_mmhg")


def _open_share(pump: float, bore: float) -> float:
    """Share of the set point that an adult's open line keeps, pump and bore off by factors."""
    catheter = CATHETERS[BY_AGE_GROUP[AgeGroup.ADULT]].outer_mm
    profile = PROFILE._replace(pump_l_per_min=PROFILE.pump_l_per_min * pump / bore)
    return line_limits(profile, catheter, SET).open_low_share / OPEN_LOW_SHARE


def _relative(name: str) -> float:
    return spread(name) / CLINICAL[name].value


PUMP, BORE = _relative("pump_free_l_per_min"), _relative("bore_l_per_min")
OPEN = line_limits(PROFILE, CATHETERS[BY_AGE_GROUP[AgeGroup.ADULT]].outer_mm, SET)
SMALL = line_limits(PROFILE, CATHETERS[BY_AGE_GROUP[AgeGroup.NEONATE]].outer_mm, LEAST_SET)
SOUND_OPEN = SET * _open_share(1.0, 1.0)
LEAST_OPEN = SET * _open_share(1.0 - PUMP, 1.0 + BORE)
MOST_OPEN = SET * _open_share(1.0 + PUMP, 1.0 - BORE)
LEAK_PER_S = most("leak_ml_per_s_per_mmhg") * ATMOSPHERE_MMHG / least("canister_ml")
"""Share of its vacuum that the leakiest sound line loses in a second."""
FALL = SMALL.bore_fall_mmhg_per_s
"""At the set point, where a thin catheter's flow is asked for."""


def _rise(free_l_per_min: float, occluded_mmhg: float, canister_ml: float, leak: float) -> float:
    """Rise of a closed line that has nearly been built, mmHg/s."""
    level = vacuum_signature.READY_SHARE * SET
    ml_per_s = free_l_per_min * ML_PER_S * (1.0 - level / occluded_mmhg) - leak * level
    return ml_per_s * ATMOSPHERE_MMHG / canister_ml


SOUND_RISE = _rise(PROFILE.pump_l_per_min, PROFILE.pump_occluded_mmhg, PROFILE.canister_ml, 0.0)
LEAST_RISE = _rise(
    least("pump_free_l_per_min"),
    least("pump_occluded_mmhg"),
    most("canister_ml"),
    most("leak_ml_per_s_per_mmhg"),
)


class Place(NamedTuple):
    """Where a threshold lies, mmHg."""

    margin: float
    """From what an ideal line shows."""
    level: float
    """What the line has."""
    beyond: float
    """By how much a sound line is nearer than an ideal one."""


def _watch(*names: str) -> tuple[Constant, ...]:
    return tuple((WATCH, name) for name in names)


def row(
    constants: tuple[Constant, ...],
    compared: str,
    place: Place,
    because: str,
    faults: tuple[Fault, ...],
    takes_s: float,
    simulated: str = "",
) -> Threshold:
    """A threshold on the vacuum as it is read."""
    return Threshold(
        constants=constants,
        compared=compared,
        unit="mmHg",
        margin=place.margin,
        bear=lambda errors: reading(errors, place.level, place.beyond),
        because=because,
        errors=SENSOR,
        chance=Chance.FILTERED,
        behind=SMOOTH,
        ticks=1,
        faults=faults,
        takes_s=takes_s,
        simulated=simulated,
    )


def _rest(errors: Errors) -> Borne:
    """The vacuum that is kept begins at the highest that noise has shown."""
    sigma = SLOW.ratio * errors["vacuum_noise_mmhg"]
    return Borne(static=SPREAD_LIMIT * sigma, sigma=sigma)


def _fall(errors: Errors) -> Borne:
    """Fall of a free catheter whose bore and canister are off."""
    model = FALL * (BORE + _relative("canister_ml") + errors["vacuum_gain"])
    return Borne(static=model, sigma=RATE.ratio * errors["vacuum_noise_mmhg"])


def _building(errors: Errors) -> Borne:
    """Rise of the weakest pump that is drawn, in the largest canister."""
    return Borne(
        static=SOUND_RISE - LEAST_RISE * (1.0 - errors["vacuum_gain"]),
        sigma=RATE.ratio * errors["vacuum_noise_mmhg"],
    )


def thresholds() -> list[Threshold]:
    """What the governor watches while a cycle runs, and what the way in waits for."""
    filter_s, low_s = vacuum_signature.FILTER_S, vacuum_signature.CLOSED_LOW_S
    flow_s = vacuum_signature.NO_FLOW_S + vacuum_signature.REST_SETTLE_S + vacuum_signature.RATE_S
    template = row((), "", Place(0.0, 0.0, 0.0), "", (), 0.0)
    return [
        row(
            _watch("CLOSED_SHARE", "CLOSED_LOW_S"),
            f"vacuum behind a closed valve, under a neonate's {LEAST_SET:g} mmHg",
            Place((1.0 - vacuum_signature.CLOSED_SHARE) * LEAST_SET, LEAST_SET, 0.0),
            "gain, what the offset has drifted since it was learnt, half a step",
            (Fault.LINE_LEAK, Fault.PUMP_LOST),
            low_s + filter_s,
            "closed",
        ),
        template._replace(
            constants=_watch("BUILDING_MMHG", "BEGUN_S"),
            compared=f"rise of a line that is pumped, nearly at an adult's {SET:g} mmHg",
            unit="mmHg/s",
            margin=SOUND_RISE - vacuum_signature.BUILDING_MMHG / vacuum_signature.RATE_S,
            bear=_building,
            because="weakest pump, largest canister, leak, gain",
            behind=RATE,
            faults=(Fault.VALVE_STUCK_OPEN, Fault.PUMP_LOST, Fault.LINE_LEAK),
            takes_s=vacuum_signature.BEGUN_S + low_s + filter_s,
        ),
        row(
            (
                ("procedure.cycle.progress", "KEPT_MMHG"),
                ("procedure.cycle.progress", "KEPT_S"),
            ),
            f"vacuum that the line must keep before the way in, an adult's {MOST_IN:g} mmHg",
            Place(progress.KEPT_MMHG, MOST_IN, LEAK_PER_S * progress.KEPT_S * MOST_IN),
            "gain, drift, the leakiest sound line; the insertion waits, it is no trip",
            (Fault.VALVE_STUCK_OPEN, Fault.REGULATOR_FAILED),
            progress.KEPT_S + filter_s,
        ),
        row(
            (("controller.governor_limit", "OPEN_LOW_SHARE"), *_watch("OPEN_LOW_S")),
            f"vacuum with the valve open, an adult's {SET:g} mmHg, 12 Fr",
            Place(SOUND_OPEN - OPEN.open_low_share * SET, LEAST_OPEN, SOUND_OPEN - LEAST_OPEN),
            "pump as weak and bore as wide as drawn; the sensor as above",
            (Fault.PUMP_WEAK, Fault.LINE_LEAK),
            vacuum_signature.OPEN_LOW_S + filter_s,
        ),
        row(
            (("controller.governor_limit", "CLOGGED_SHARE"), *_watch("CLOGGED_S")),
            f"the same, too high; without mucus, {SET:g} mmHg, 12 Fr",
            Place(OPEN.clogged_share * SET - SOUND_OPEN, MOST_OPEN, MOST_OPEN - SOUND_OPEN),
            "pump as strong and bore as narrow as drawn; plugs only by the time that they last",
            (Fault.LINE_CLOGGED,),
            vacuum_signature.CLOGGED_S + filter_s,
        ),
        template._replace(
            constants=_watch("FLOW_SHARE", "NO_FLOW_S"),
            compared="fall of the resting line with the valve open, a neonate's free 6 Fr",
            unit="mmHg/s",
            margin=(1.0 - vacuum_signature.FLOW_SHARE) * FALL,
            bear=_fall,
            because="bore, canister, gain; mucus takes more, down to a fourth [in-silico]",
            behind=RATE,
            faults=(Fault.LINE_CLOGGED, Fault.VALVE_STUCK_CLOSED),
            takes_s=flow_s + filter_s,
        ),
        template._replace(
            constants=_watch("REST_FALL_MMHG", "REST_LOW_S"),
            compared="vacuum that a resting line has lost beyond what it may",
            margin=vacuum_signature.REST_FALL_MMHG,
            bear=_rest,
            because="noise in the vacuum that it began with, 2.5 sigma; the leakiest sound line "
            f"loses {100.0 * LEAK_PER_S:.1f} % a second of the "
            f"{100.0 * vacuum_signature.REST_SHARE_PER_S:.0f} % that are allowed",
            behind=SLOW,
            faults=(Fault.LINE_LEAK, Fault.VALVE_STUCK_OPEN),
            takes_s=vacuum_signature.REST_LOW_S + vacuum_signature.RATE_S + filter_s,
            simulated="resting",
        ),
        template._replace(
            constants=_watch("REST_NOISE_MMHG_PER_S"),
            compared="that loss's rate against an open catheter's: only which of both is named",
            unit="mmHg/s",
            margin=vacuum_signature.REST_NOISE_MMHG_PER_S,
            bear=lambda errors: Borne(0.0, RATE.ratio * errors["vacuum_noise_mmhg"]),
            because="none counted: a wider bore is seen before",
            errors=("vacuum_noise_mmhg",),
            behind=RATE,
            faults=(Fault.LINE_LEAK,),
            takes_s=vacuum_signature.REST_LOW_S + vacuum_signature.RATE_S + filter_s,
        ),
        row(
            _watch("OVER_MMHG", "OVER_S"),
            f"vacuum over the set point of {SET:g} mmHg",
            Place(vacuum_signature.OVER_MMHG, SET, over_set(SET)),
            "strongest pump against the weakest regulator, gain, drift",
            (Fault.REGULATOR_FAILED, Fault.PUMP_RUNAWAY),
            vacuum_signature.OVER_S + filter_s,
            "closed",
        ),
        row(
            _watch("OVER_REST_MMHG", "OVER_S"),
            f"the same while the pump rests, a child's {CHILD_SET:g} mmHg",
            Place(vacuum_signature.OVER_REST_MMHG, CHILD_SET, 0.0),
            "gain, drift: nothing holds a sound line above its set point",
            (Fault.REGULATOR_FAILED, Fault.PUMP_RUNAWAY),
            vacuum_signature.OVER_S + filter_s,
        ),
        row(
            (
                ("controller.governor_limit", "VACUUM_MARGIN"),
                ("safety.governor.judgement", "PERSISTENCE_S"),
            ),
            f"vacuum over a neonate's set point of {LEAST_SET:g} mmHg",
            Place(
                min(VACUUM_MARGIN * LEAST_SET, GUIDELINES[AgeGroup.NEONATE].vacuum_mmhg)
                - LEAST_SET,
                LEAST_SET,
                over_set(LEAST_SET),
            ),
            "as above",
            (Fault.REGULATOR_FAILED, Fault.PUMP_RUNAWAY),
            PERSISTENCE_S + filter_s,
            "closed",
        ),
        row(
            _watch("OVER_MMHG", "VENTED_S"),
            "vacuum of a vented line",
            Place(vacuum_signature.OVER_MMHG, 0.0, 0.0),
            "what is left of the offset",
            (Fault.PUMP_RUNAWAY, Fault.REGULATOR_FAILED),
            vacuum_signature.VENTED_S + filter_s,
            "vented",
        ),
    ]
