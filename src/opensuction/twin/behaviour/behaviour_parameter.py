"""Parameters of what patients do of their own accord: rows of `patient_parameter`.

Rates are those of somebody awake; `sedation_ratio` scales them. Nearly all is assumed: what is
published counts patients or procedures in which something happened, not how often a patient does
it.

Spontaneous behaviour of a patient from its parameters, with the switch that enables it.
"""

from opensuction.kernel.unit import HOUR_S
from opensuction.twin.behaviour.behaviour import Artefact, Behaviour, Clearance
from opensuction.twin.behaviour.spontaneous_event import Cough, Effort, Posture
from opensuction.twin.parameter import ParameterValues
from opensuction.twin.parameter_row import Numbers, Words

SEDATED_PUSH = 0.5
"""[assumed] Share of a cough's pressure that the deepest sedation takes."""

SWITCH = "lively"
"""The row that says whether the others do anything."""

ROWS: dict[str, tuple[Numbers, Words]] = {
    SWITCH: (
        (1, "1", (0, 1)),
        ("whether the patient does any of what follows: 1, or 0 for a quiet one", "[assumed]"),
    ),
    "sedation_ratio": (
        (((0.5, 0.12), (0.75, 0.08), (0.5, 0.12), (0.4, 0.12)), "1", (0, 1)),
        ("depth of sedation: coughs and breaths are rarer and weaker by it", "[assumed]"),
    ),
    # Coughs
    "cough_per_h": (
        (((6, 2), (6, 2), (6, 2), (6, 2)), "1/h", (0, 120)),
        ("coughs without a catheter", "[assumed]"),
    ),
    "provoked_cough_per_min": (
        (((12, 3), (12, 3), (12, 3), (12, 3)), "1/min", (0, 120)),
        ("coughs at the strongest stimulus of a catheter", "[assumed]"),
    ),
    "cough_cmh2o": (
        (((90, 8), (90, 8), (60, 7), (40, 5)), "cmH2O", (5, 250)),
        ("peak of the muscles' pressure", "[assumed] 30 to 120 in a sedated adult; children less"),
    ),
    "cough_s": (
        (((0.3, 0.03), (0.3, 0.03), (0.25, 0.02), (0.2, 0.02)), "s", (0.1, 0.6)),
        ("how long they push", "[assumed] .2 to .4"),
    ),
    "cough_refractory_s": ((1.5, "s", (0.3, 30)), ("least time between two coughs", "[assumed]")),
    "shortening_mm_per_cmh2o": (
        (((0.06, 0.01), (0.06, 0.01), (0.04, 0.006), (0.03, 0.005)), "mm/cmH2O", (0, 0.2)),
        ("way of the carina towards the tube for each cmH2O of the muscles", "[assumed]"),
    ),
    # Own breaths
    "effort_per_min": (
        (((10, 3), (10, 3), (15, 4), (25, 6)), "1/min", (0, 80)),
        ("own breaths against the ventilator", "[assumed]"),
    ),
    "effort_cmh2o": (
        (((6, 1.2), (6, 1.2), (5, 1), (4, 0.8)), "cmH2O", (0, 30)),
        ("peak of their pull", "[assumed] 2 to 10"),
    ),
    # Head and neck
    "posture_per_h": ((2, "1/h", (0, 60)), ("moves of head, neck and conduit", "[assumed]")),
    "posture_inside_ratio": (
        (0.1, "1", (0, 1)),
        ("share of that rate with the catheter inside", "[assumed]"),
    ),
    "posture_mm": (
        (((3, 0), (3, 0), (0.7, 0), (0.5, 0)), "mm", (0, 8)),
        (
            "standard deviation of the carina's depth over postures",
            "[assumed] flexion moves a tip by 2 cm at most [K]; children as their tracheas",
        ),
    ),
    "posture_gap_ratio": (
        (0.04, "1", (0, 0.09)),
        ("standard deviation of the conduit's gap over postures, as a share of it", "[assumed]"),
    ),
    # Oximeter
    "artefact_per_h": (
        (((4, 1.2), (4, 1.2), (6, 2), (6, 2)), "1/h", (0, 240)),
        ("values of the oximeter that are wrong or missing for some seconds", "[assumed]"),
    ),
    "artefact_cough_ratio": (
        (20, "1", (1, 200)),
        ("times as often within 5 s of a cough", "[assumed]"),
    ),
    # Leak
    "leak_ml_per_s_per_cmh2o": (
        (((1, 0.35), (1, 0.35), (0.3, 0.1), (0.3, 0.1)), "mL/s/cmH2O", (0, 10)),
        ("gas that leaves beside the tube", "[assumed]"),
    ),
    # Secretions
    "cilia_mm_per_min": (
        (((3, 0.8), (3, 0.8), (3, 0.8), (3, 0.8)), "mm/min", (0, 25)),
        ("speed at which cilia carry secretions", "[K] 5 to 15 in health, less when intubated"),
    ),
    "cough_mm_per_s_per_cmh2o": (
        (1.5, "mm/s/cmH2O", (0, 10)),
        ("speed of secretions in a cough for each cmH2O of the muscles", "[assumed]"),
    ),
    "expelled_ratio": (
        (0.2, "1", (0, 1)),
        ("share of what a cough drives to the tube that leaves through it", "[assumed]"),
    ),
    "adherent_ratio": (
        (((0.2, 0.06), (0.2, 0.06), (0.2, 0.06), (0.2, 0.06)), "1", (0, 0.5)),
        ("share of secretions that stick", "[assumed]"),
    ),
    "loosening_h": ((2, "h", (0.05, 48)), ("time constant of their coming loose", "[assumed]")),
    "deep_ratio": (
        (((0.15, 0.05), (0.2, 0.06), (0.15, 0.05), (0.15, 0.05)), "1", (0, 0.45)),
        ("share of secretions below the carina", "[assumed]"),
    ),
    "secretion_resistance_ratio": (
        (((0.15, 0.04), (0.15, 0.04), (0.25, 0.06), (0.25, 0.06)), "1", (0, 0.6)),
        ("share of the airways' resistance that the usual secretions make", "[assumed]"),
    ),
    # Oxygen
    "perfusion_ratio": (
        (((1.2, 0.3), (1.2, 0.3), (1, 0.3), (1, 0.3)), "1", (0, 2.5)),
        (
            "blood flow that closed lung keeps, over `closed_perfusion`",
            "[calibrated] SpO2 falls by 5 points in 5 to 7 % of adults' suctionings "
            "[Maggiore-2013]; children [assumed]",
        ),
    ),
}
"""Numbers and words of each, as in `patient_parameter`."""


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
