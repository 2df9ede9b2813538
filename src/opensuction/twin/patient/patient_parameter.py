"""Every parameter of the patients: value, spread between patients, unit, meaning and source.

`docs/reference/parameters.md` shows this table. Plausible ranges, which bound what a file may set,
are the project's own judgement. Tags of the sources: docs/sources.md.
"""

from opensuction.twin.behaviour import behaviour_parameter
from opensuction.twin.parameter_row import Numbers, Parameter, Words

PRESETS = ("adult-icu", "adult-ards", "child-10kg", "neonate")
"""Patients by name, in the order of the cells below; the first is the default."""

_ROWS: dict[str, tuple[Numbers, Words]] = {
    # Anatomy and tube
    "weight_kg": (
        (((70, 8), (70, 8), (10, 0.6), (3.5, 0.25)), "kg", (0.8, 200)),
        ("predicted body weight", "[assumed]"),
    ),
    "tube_id_mm": (
        (((8.5, 0), (8.5, 0), (4.5, 0), (3.5, 0)), "mm", (2.5, 11)),
        (
            "inner diameter of the tube",
            "[computed] a 4 mm catheter under half of it; 6 Fr (2 mm) for the small ones",
        ),
    ),
    "tube_length_mm": (
        (((80, 0), (80, 0), (42, 0), (32, 0)), "mm", (20, 160)),
        ("length of the tube", "[K]"),
    ),
    "carina_mm": (
        (((65, 10), (65, 10), (15, 2), (12, 0.8)), "mm", (3, 130)),
        ("lower end of the tube to carina", "[K] adult 40 to 90; [ATS-2000] child 10 to 20"),
    ),
    "carina_n_per_mm": (
        (((0.35, 0.07), (0.35, 0.07), (0.15, 0.03), (0.12, 0.02)), "N/mm", (0.03, 5)),
        ("stiffness under the tip", "[computed] 2 E a: .16 to .53 for 12 Fr, half of it for 6 Fr"),
    ),
    # Secretions
    "secretion_ml": (
        (((3, 0.8), (2, 0.6), (0.8, 0.2), (0.4, 0.1)), "mL", (0.05, 20)),
        ("secretions in the trachea", "[K] .5 to 5 a pass; children [assumed]"),
    ),
    "secretion_depth_ratio": (
        (((0.7, 0.1), (0.7, 0.1), (0.5, 0.1), (0.5, 0.1)), "1", (0.05, 1)),
        ("depth around which they lie, as a share of the way to the carina", "[assumed]"),
    ),
    "secretion_spread_ratio": (
        (0.4, "1", (0.1, 1)),
        ("half of their length, likewise", "[assumed]"),
    ),
    "viscosity_pa_s": (
        (((0.5, 0.15), (0.5, 0.15), (0.3, 0.1), (0.3, 0.1)), "Pa s", (0.02, 10)),
        ("at 100 /s", "[K] .02 to 1"),
    ),
    "yield_pa": ((5, "Pa", (0, 200)), ("stress below which they do not flow", "[K] .5 to 50")),
    "production_ml_per_h": (
        (((2, 0.4), (2, 0.4), (0.5, 0.1), (0.2, 0.04)), "mL/h", (0, 40)),
        ("new secretions", "[K] 10 to 50 mL a day; children [assumed]"),
    ),
    # Ventilator
    "peep_cmh2o": ((((6, 0), (12, 0), (5, 0), (5, 0)), "cmH2O", (0, 25)), ("PEEP", "[K]")),
    "tidal_ml_per_kg": (
        (((7, 0.25), (6.4, 0.12), (7, 0.25), (6.6, 0.15)), "mL/kg", (3, 12)),
        ("tidal volume for which the driving pressure was set", "[K] 6 to 8"),
    ),
    "rate_per_min": ((((15, 0), (20, 0), (28, 0), (40, 0)), "1/min", (5, 80)), ("breaths", "[K]")),
    "inspiration_ratio": ((0.33, "1", (0.15, 0.6)), ("share of inspiration", "[K] I:E 1:2")),
    "oxygen_ratio": ((((0.4, 0), (0.6, 0), (0.3, 0), (0.25, 0)), "1", (0.21, 1)), ("FiO2", "[K]")),
    "rise_s": (
        (((0.1, 0), (0.1, 0), (0.08, 0), (0.05, 0)), "s", (0.01, 0.4)),
        ("pressure rise, time constant", "[K]"),
    ),
    "fall_s": ((0.05, "s", (0.01, 0.3)), ("opening of the expiratory valve, time constant", "[K]")),
    "source_cmh2o_s_per_l": (
        (((1, 0), (1, 0), (4, 0), (8, 0)), "cmH2O s/L", (0, 30)),
        ("pressure missing for the flow of inspiration", "[assumed]"),
    ),
    "peak_l_per_min": (
        (((120, 0), (120, 0), (60, 0), (40, 0)), "L/min", (10, 240)),
        ("most flow of inspiration", "[K]"),
    ),
    "droop_cmh2o_s_per_l": (
        (((14, 1.5), (14, 1.5), (45, 6), (60, 8)), "cmH2O s/L", (0, 120)),
        (
            "pressure missing for the flow compensation of expiration",
            "[calibrated] PEEP 6 falls to 5 or 3 on a bench [Nakstad-2016]; children [assumed]",
        ),
    ),
    "compensation_l_per_min": (
        (30, "L/min", (0, 200)),
        ("most flow compensation", "[K] 30 or more"),
    ),
    "valve_cmh2o_s_per_l": (
        (((4, 0), (4, 0), (8, 0), (15, 0)), "cmH2O s/L", (0.5, 50)),
        ("expiratory limb and valve", "[assumed]"),
    ),
    # Lung
    "compliance_ml_per_cmh2o_per_kg": (
        (((0.75, 0.05), (0.45, 0.035), (1, 0.1), (1, 0.1)), "mL/cmH2O/kg", (0.15, 2.5)),
        ("lung and chest wall", "[K] adult 50 to 60, ARDS 25 to 35 mL/cmH2O; neonate 1 a kg"),
    ),
    "resistance_cmh2o_s_per_l": (
        (((9, 1.2), (10, 1.2), (25, 4), (40, 6)), "cmH2O s/L", (2, 150)),
        ("airways below the tube", "[K] adult 8 to 15; children [assumed]"),
    ),
    "relaxed_ml_per_kg": (
        (((22, 2), (26, 2), (27, 2), (27, 2)), "mL/kg", (8, 50)),
        (
            "gas at zero pressure with all units open",
            "[K] sedated adult 1.5 L, child and neonate 25 to 30; ARDS [calibrated] as closable",
        ),
    ),
    "residual_ml_per_kg": (
        (((8, 0), (4, 0), (8, 0), (8, 0)), "mL/kg", (1, 25)),
        ("gas that suction cannot take", "[assumed]"),
    ),
    "closing_margin_cmh2o": (
        (0.2, "cmH2O", (0, 3)),
        ("pressure lost below PEEP before units close", "[assumed]"),
    ),
    "closable_ml_per_kg": (
        (((6, 1.2), (16, 2), (6, 1.2), (6, 1.2)), "mL/kg", (0, 30)),
        (
            "units that can close",
            "[calibrated] ARDS: loss on disconnection and in closed suction [Maggiore-2003]",
        ),
    ),
    "half_closing_cmh2o": (
        (((4, 0), (0.9, 0), (4, 0), (4, 0)), "cmH2O", (0.3, 15)),
        ("pressure lost that closes half of them", "[calibrated] as closable"),
    ),
    "closing_s": ((1, "s", (0.1, 10)), ("time constant of closing", "[calibrated] as closable")),
    "opening_s": ((150, "s", (10, 1800)), ("time constant of reopening", "[computed] 2 to 4 min")),
    # Oxygen
    "dead_space_ml_per_kg": (
        (((1.9, 0), (2.2, 0), (2.2, 0), (2.2, 0)), "mL/kg", (0.5, 6)),
        (
            "dead space with tube, connector and filter",
            "[calibrated] 863 VO2 / alveolar ventilation near 40 mmHg",
        ),
    ),
    "oxygen_ml_per_min_per_kg": (
        (((3.5, 0.2), (4, 0.2), (6.5, 0.3), (7, 0.3)), "mL/min/kg", (2, 12)),
        ("oxygen consumption", "[K] adult 3 to 4, child 6 to 7, neonate 6 to 8"),
    ),
    "output_l_per_min_per_kg": (
        (((0.08, 0.006), (0.09, 0.006), (0.2, 0.015), (0.2, 0.015)), "L/min/kg", (0.03, 0.4)),
        ("cardiac output", "[K]"),
    ),
    "haemoglobin_g_per_dl": (
        (((11, 0.8), (10.5, 0.8), (11.5, 0.8), (15, 1)), "g/dL", (5, 22)),
        ("haemoglobin, 1.34 mL/g", "[K]"),
    ),
    "p50_mmhg": (
        (((26.9, 0), (26.9, 0), (26.9, 0), (20, 0.6)), "mmHg", (17, 35)),
        ("pressure at half saturation", "[K]"),
    ),
    "venous_ml_per_kg": (
        (((50, 0), (50, 0), (55, 0), (60, 0)), "mL/kg", (20, 120)),
        ("venous blood and tissue store", "[K]"),
    ),
    "shunt": (
        (((0.15, 0.02), (0.3, 0.02), (0.12, 0.015), (0.15, 0.02)), "1", (0, 0.5)),
        (
            "blood past all alveoli, lung open",
            "[K] normal .05 to .1, intensive care .15, ARDS .3; children [assumed]",
        ),
    ),
    "closed_perfusion": (
        (0.4, "1", (0, 1)),
        (
            "share of its blood flow that closed lung keeps",
            "[calibrated] SpO2 falls 0 to 5 points; [K] vasoconstriction about halves it",
        ),
    ),
    "delay_s": (
        (((20, 2.5), (20, 2.5), (14, 1.5), (12, 0.8)), "s", (4, 30)),
        ("lung to finger", "[K] 10 to 30"),
    ),
    "average_s": ((8, "s", (2, 16)), ("averaging of the oximeter", "[K] 4 to 16")),
    # Heart
    "heart_rate_per_min": (
        (((85, 7), (95, 7), (120, 8), (145, 7)), "1/min", (30, 220)),
        ("heart rate at rest", "[K]"),
    ),
    "vagal_ratio": (
        (((0.05, 0.015), (0.05, 0.015), (0.07, 0.015), (0.08, 0.02)), "1", (0, 0.8)),
        (
            "share of the heart rate that the strongest stimulus of the airway takes",
            "[assumed] bradycardia in .5 to 2 % of suctionings [K] is a fault here, not a draw",
        ),
    ),
    "vagal_s": ((2, "s", (0.5, 10)), ("rise of the vagal tone, time constant", "[assumed]")),
    "vagal_recovery_s": (
        (8, "s", (1, 60)),
        ("fading of the vagal tone, time constant", "[assumed]"),
    ),
    "hypoxic_ratio": (
        (((0.6, 0), (0.6, 0), (0.7, 0), (0.7, 0)), "1", (0.2, 0.9)),
        ("arterial saturation below which hypoxia slows the heart", "[assumed] sooner in children"),
    ),
    "beat_average_s": (
        (2, "s", (0.2, 10)),
        ("averaging of the shown heart rate, time constant", "[assumed]"),
    ),
}


def _row(numbers: Numbers, words: Words) -> tuple[Parameter, ...]:
    """The parameter of each preset."""
    values, unit, (low, high) = numbers
    cells = values if isinstance(values, tuple) else ((values, 0.0),) * len(PRESETS)
    return tuple(
        Parameter(float(value), float(spread), unit, *words, float(low), float(high))
        for value, spread in cells
    )


ROWS: dict[str, tuple[Parameter, ...]] = {
    name: _row(*row) for name, row in (_ROWS | behaviour_parameter.ROWS).items()
}
"""Every parameter, for each preset."""

PATIENT_TABLES: dict[str, dict[str, Parameter]] = {
    name: {key: row[i] for key, row in ROWS.items()} for i, name in enumerate(PRESETS)
}
"""Parameters of every preset by name."""
