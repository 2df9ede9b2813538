"""Thresholds of the pre-use test on the suction line's vacuum: a miss refuses a start."""

import math

from docs.generator.safety.tolerance.line import (
    LEAK_PER_S,
    LEAST_SET,
    SET,
    SMOOTH,
    Place,
    over_set,
    pumped,
    row,
)
from docs.generator.safety.tolerance.noise import low_pass
from docs.generator.safety.tolerance.sensor_error import Errors, least, spread
from docs.generator.safety.tolerance.threshold import Borne, Threshold
from opensuction.controller.machine_profile import CLINICAL as PROFILE
from opensuction.procedure.cycle import check
from opensuction.procedure.cycle.check import CheckItem
from opensuction.procedure.planning import protocol
from opensuction.safety.watch import vacuum_signature
from opensuction.twin.fault.fault import Fault

CHECK = "procedure.cycle.check"
LEAK = low_pass(vacuum_signature.FILTER_S, check.LEAK_AVERAGE_S)
RELIEVED = PROFILE.relief_mmhg
RELIEF_OVER = spread("relief_mmhg") + pumped(RELIEVED) / least("relief_ml_per_s_per_mmhg")
LOWERED = protocol.LOWERED_SHARE * SET


def _zero(errors: Errors) -> Borne:
    """A vented line, before its offset is learnt."""
    static = errors["vacuum_offset_mmhg"] + errors["vacuum_drift_mmhg"]
    return Borne(
        static=static + 0.5 * errors["vacuum_step_mmhg"],
        sigma=SMOOTH.ratio * errors["vacuum_noise_mmhg"],
    )


def _leak(errors: Errors) -> Borne:
    """Loss in the second of a sound line, and the noise of both vacuums that are compared."""
    loss_s = check.VACUUM_SETTLE_S + check.LEAK_S - check.LEAK_AVERAGE_S
    ratio = math.hypot(SMOOTH.ratio, LEAK.ratio)
    loss = LEAST_SET * (1.0 - math.exp(-LEAK_PER_S * loss_s))
    return Borne(static=loss, sigma=ratio * errors["vacuum_noise_mmhg"])


def thresholds() -> list[Threshold]:
    """What the pre-use test holds the line to; a miss is a refusal to start, not a trip."""
    template = row((), "", Place(0.0, 0.0, 0.0), "", (), 0.0)
    return [
        template._replace(
            constants=(("safety.watch.vacuum_signature", "ZERO_MMHG"),),
            compared="a vented line's reading, up to which it is learnt as offset",
            margin=vacuum_signature.ZERO_MMHG,
            bear=_zero,
            because="offset and drift themselves",
            faults=(Fault.VACUUM_SENSOR_OFFSET,),
            takes_s=protocol.SENSOR_LIMIT_S,
            simulated="vented",
        ),
        row(
            ((CHECK, "VENTED_MMHG"), (CHECK, "HOLD_S")),
            "the same, once it is learnt",
            Place(check.VENTED_MMHG, 0.0, 0.0),
            "what is left of the offset",
            (Fault.VACUUM_SENSOR_OFFSET, Fault.VACUUM_SENSOR_NOISY),
            protocol.SENSOR_LIMIT_S,
            "vented",
        ),
        row(
            (("procedure.planning.protocol", "VACUUM_READY_SHARE"),),
            f"vacuum that the pump must reach and hold, of {LEAST_SET:g} mmHg",
            Place((1.0 - protocol.VACUUM_READY_SHARE) * LEAST_SET, LEAST_SET, 0.0),
            "gain, drift",
            (Fault.PUMP_WEAK, Fault.LINE_LEAK),
            protocol.VACUUM_LIMIT_S,
        ),
        template._replace(
            constants=((CHECK, "LEAK_SHARE"), (CHECK, "LEAK_S")),
            compared=f"loss of a resting line in the pre-use test's second, of {LEAST_SET:g} mmHg",
            margin=check.LEAK_SHARE * LEAST_SET,
            bear=_leak,
            because="the leakiest sound line, smallest canister",
            errors=("vacuum_noise_mmhg",),
            behind=SMOOTH,
            faults=(Fault.LINE_LEAK,),
            takes_s=protocol.LIMITS_S[CheckItem.VACUUM_HOLDS],
            simulated="leak",
        ),
        row(
            ((CHECK, "NEAR_MMHG"), (CHECK, "LEVEL_S")),
            f"vacuum over the relief valve's {RELIEVED:g} mmHg",
            Place(check.NEAR_MMHG, RELIEVED, RELIEF_OVER),
            "a stiff relief valve against the strongest pump, gain, drift",
            (Fault.RELIEF_FAILED, Fault.VACUUM_SENSOR_OFFSET),
            protocol.RELIEF_LIMIT_S,
            "relief",
        ),
        row(
            ((CHECK, "NEAR_MMHG"), (CHECK, "LEVEL_S")),
            f"vacuum over the lowered set point of {LOWERED:g} mmHg",
            Place(check.NEAR_MMHG, LOWERED, over_set(LOWERED)),
            "strongest pump against the weakest regulator, gain, drift",
            (Fault.REGULATOR_FAILED,),
            protocol.REGULATOR_LIMIT_S,
        ),
    ]
