"""Spontaneous behaviour of a patient from its parameters, with the switch that enables it."""

from opensuction.kernel.constant import HOUR_S
from opensuction.twin.behaviour.artefact import Artefact
from opensuction.twin.behaviour.behaviour import Behaviour
from opensuction.twin.behaviour.behaviour_parameter import SEDATED_PUSH, SWITCH
from opensuction.twin.behaviour.clearance import Clearance
from opensuction.twin.behaviour.cough import Cough
from opensuction.twin.behaviour.effort import Effort
from opensuction.twin.behaviour.posture import Posture
from opensuction.twin.parameter import ParameterValues

MINUTE_S = 60.0


def _clearance(values: ParameterValues) -> Clearance:
    return Clearance(
        cilia_mm_per_s=values["cilia_mm_per_min"] / MINUTE_S,
        cough_mm_per_s_per_cmh2o=values["cough_mm_per_s_per_cmh2o"],
        expelled_share=values["expelled_ratio"],
        adherent_share=values["adherent_ratio"],
        loosening_s=values["loosening_h"] * HOUR_S,
        deep_share=values["deep_ratio"],
        resistance_share=values["secretion_resistance_ratio"],
        usual_ml=values["secretion_ml"],
    )


def assemble(values: ParameterValues) -> Behaviour:
    """Assemble a patient's behaviour from a full set of parameters."""
    awake = 1.0 - values["sedation_ratio"]
    return Behaviour(
        is_lively=values[SWITCH] == 1.0,
        cough=Cough(
            spontaneous_per_s=awake * values["cough_per_h"] / HOUR_S,
            provoked_per_s=awake * values["provoked_cough_per_min"] / MINUTE_S,
            peak_cmh2o=values["cough_cmh2o"] * (1.0 - SEDATED_PUSH * values["sedation_ratio"]),
            push_s=values["cough_s"],
            refractory_s=values["cough_refractory_s"],
        ),
        effort=Effort(
            per_s=awake * values["effort_per_min"] / MINUTE_S, peak_cmh2o=values["effort_cmh2o"]
        ),
        posture=Posture(
            per_s=values["posture_per_h"] / HOUR_S,
            inside_share=values["posture_inside_ratio"],
            carina_mm=values["posture_mm"],
            gap_ratio=values["posture_gap_ratio"],
        ),
        artefact=Artefact(
            per_s=values["artefact_per_h"] / HOUR_S, cough_ratio=values["artefact_cough_ratio"]
        ),
        clearance=_clearance(values),
        leak_ml_per_s_per_cmh2o=values["leak_ml_per_s_per_cmh2o"],
        perfusion_ratio=values["perfusion_ratio"],
        shortening_mm_per_cmh2o=values["shortening_mm_per_cmh2o"],
    )
