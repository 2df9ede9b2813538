"""A kind of patient: what a name or a file describes, before a seed draws one patient of it.

What does not fit together in one body is refused with the arithmetic. Tags as in
`patient_parameter`.
"""

from typing import NamedTuple

from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import AgeGroup
from opensuction.twin import parameter
from opensuction.twin.behaviour.behaviour_parameter import SWITCH
from opensuction.twin.parameter import ParameterValues
from opensuction.twin.parameter_row import Parameter
from opensuction.twin.patient import patient_preset
from opensuction.twin.patient.gas_exchange import DRY_MMHG
from opensuction.twin.patient.patient import Patient
from opensuction.twin.patient.patient_parameter import PATIENT_TABLES


class Anatomy(NamedTuple):
    """Anatomy of an age: the range that it allows."""

    weight_kg: tuple[float, float]
    tube_id_mm: tuple[float, float]
    trachea_mm: float
    """Longest trachea, larynx to carina."""


ANATOMY = {
    AgeGroup.ADULT: Anatomy((30.0, 200.0), (5.0, 11.0), 130.0),
    AgeGroup.CHILD: Anatomy((3.0, 50.0), (3.0, 7.0), 93.0),
    AgeGroup.NEONATE: Anatomy((0.8, 6.0), (2.5, 4.5), 50.0),
}
"""Limits by age."""

ANATOMY_SOURCES = {
    "weight_kg": "[assumed]",
    "tube_id_mm": "[K] tracheostomy tubes by age",
    "trachea_mm": "adult 100 to 130 [K]; child and neonate .050 x height + 17.8 mm [Griscom-1989], "
    "[computed] for 150 cm, beyond the formula's 6 years [assumed], and 64 cm",
}

IN_TRACHEA_MM = 20.0
"""Least length of a tube inside the trachea [ATS-2000]: 2 cm past the stoma."""
PEAK_CMH2O = 50.0
"""Highest inspiratory pressure that a ventilator is set to [K]."""
CO2_FACTOR = 863.0
"""Alveolar pressure in mmHg of a gas from its flow at STPD over ventilation at BTPS [K]."""
ALVEOLAR_MMHG = 50.0
"""Least alveolar oxygen pressure of a patient who is suctioned at leisure [assumed]."""
EXTRACTION = 0.7
"""Largest share of the oxygen in arterial blood that the body takes up at rest [K]."""
SETTLED = 2.0
"""A breath's phases last this many of the ventilator's time constants at least [assumed]."""


class PatientKind(NamedTuple):
    """Parameters with their spread, and the age that guidelines go by."""

    table: dict[str, Parameter]
    age: AgeGroup


def of_preset(name: str) -> PatientKind:
    """A preset by name; raises InputError for an unknown one."""
    if name not in PATIENT_TABLES:
        raise InputError(f"patient '{name}' is not known: one of {', '.join(PATIENT_TABLES)}")
    return PatientKind(PATIENT_TABLES[name], patient_preset.AGE_GROUPS[name])


def check(kind: PatientKind) -> None:
    """Refuse a patient whose values do not fit together; raises InputError with the arithmetic."""
    values = parameter.nominal(kind.table)
    _check_body(values, kind.age)
    _check_lung(values)  # a draw with more is cut to what can close
    _check_behaviour(kind)


def draw(kind: PatientKind, seed: int, nominal: bool = False, spread: float = 1.0) -> Patient:
    """A patient drawn by the seed, or exactly nominal and quiet. spread: see `parameter.draw`.

    Raises InputError where the spread draws values that do not fit together.
    """
    values = parameter.nominal(kind.table) if nominal else parameter.draw(kind.table, seed, spread)
    try:
        _check_body(values, kind.age)
    except InputError as refused:
        drawn_by = "" if nominal else f"seed {seed} draws a patient that cannot be: "
        raise InputError(f"{drawn_by}{refused}") from None
    found = patient_preset.assemble(values, kind.age)
    return patient_preset.quiet(found) if nominal else found


def _check_body(values: ParameterValues, age: AgeGroup) -> None:
    _check_anatomy(values, age)
    _check_ventilator(values)
    _check_oxygen(values)


def _check_anatomy(values: ParameterValues, age: AgeGroup) -> None:
    allowed, who = ANATOMY[age], age.name.lower()
    for name, (low, high), unit in (
        ("weight_kg", allowed.weight_kg, "kg"),
        ("tube_id_mm", allowed.tube_id_mm, "mm"),
    ):
        if not low <= values[name] <= high:
            raise InputError(
                f"{name} {values[name]:g} {unit} is not that of this preset's age ({who}: {low:g} "
                f"to {high:g} {unit}): start from another preset"
            )
    length = values["carina_mm"] + IN_TRACHEA_MM
    if length > allowed.trachea_mm:
        raise InputError(
            f"carina_mm {values['carina_mm']:g} mm below the tube and {IN_TRACHEA_MM:g} mm of the "
            f"tube inside make a trachea of {length:g} mm; the longest of this age ({who}) has "
            f"{allowed.trachea_mm:g} mm: set carina_mm to at most "
            f"{allowed.trachea_mm - IN_TRACHEA_MM:g} mm"
        )


def _check_ventilator(values: ParameterValues) -> None:
    breath_s = 60.0 / values["rate_per_min"]
    inspiration_s = breath_s * values["inspiration_ratio"]
    for name, lasts_s, part in (
        ("rise_s", inspiration_s, "inspiration"),
        ("fall_s", breath_s - inspiration_s, "expiration"),
    ):
        if SETTLED * values[name] > lasts_s:
            raise InputError(
                f"{name} {values[name]:g} s is too long for {part} of {lasts_s:.2f} s (60 s / "
                f"{values['rate_per_min']:g} breaths, inspiration_ratio "
                f"{values['inspiration_ratio']:g}): it should be at most {lasts_s / SETTLED:.2f} s"
            )
    driving = patient_preset.driving_cmh2o(values, inspiration_s)
    peak = values["peep_cmh2o"] + driving
    if peak > PEAK_CMH2O:
        raise InputError(
            f"the ventilator would need a peak pressure of {peak:.0f} cmH2O = PEEP "
            f"{values['peep_cmh2o']:g} + {driving:.0f} for {values['tidal_ml_per_kg']:g} mL/kg; "
            f"at most {PEAK_CMH2O:g} cmH2O: reduce tidal_ml_per_kg or peep_cmh2o"
        )
    if values["closing_margin_cmh2o"] > values["peep_cmh2o"]:
        raise InputError(
            f"closing_margin_cmh2o {values['closing_margin_cmh2o']:g} cmH2O is more than "
            f"peep_cmh2o {values['peep_cmh2o']:g} cmH2O"
        )


def _check_lung(values: ParameterValues) -> None:
    relaxed, residual = values["relaxed_ml_per_kg"], values["residual_ml_per_kg"]
    can_close = patient_preset.OPENABLE * (relaxed - residual)
    if values["closable_ml_per_kg"] > can_close:
        raise InputError(
            f"closable_ml_per_kg {values['closable_ml_per_kg']:g} mL/kg is more than can close: "
            f"{patient_preset.OPENABLE:g} x (relaxed {relaxed:g} - residual {residual:g}) = "
            f"{can_close:.1f} mL/kg"
        )


def _check_behaviour(kind: PatientKind) -> None:
    switch, reach = kind.table[SWITCH], parameter.SPREAD_LIMIT
    if switch.value not in (0.0, 1.0) or switch.spread != 0.0:
        raise InputError(f"{SWITCH} is {switch.value:g}: 1 for a lively patient, 0 for a quiet one")
    adherent, deep = kind.table["adherent_ratio"], kind.table["deep_ratio"]
    most = adherent.value + deep.value + reach * (adherent.spread + deep.spread)
    if most > 1.0:
        raise InputError(
            f"adherent_ratio {adherent.value:g} and deep_ratio {deep.value:g} are up to {most:.2f} "
            "of all secretions together with their spreads: at most 1"
        )


def _check_oxygen(values: ParameterValues) -> None:
    tidal, dead = values["tidal_ml_per_kg"], values["dead_space_ml_per_kg"]
    ventilation = (tidal - dead) * values["rate_per_min"]
    used = values["oxygen_ml_per_min_per_kg"]
    if ventilation <= 0.0:
        raise InputError(
            f"tidal_ml_per_kg {tidal:g} mL/kg does not pass the dead space of {dead:g} mL/kg"
        )
    inspired = DRY_MMHG * values["oxygen_ratio"]
    alveolar = inspired - CO2_FACTOR * used / ventilation
    if alveolar < ALVEOLAR_MMHG:
        raise InputError(
            f"alveolar oxygen would be {alveolar:.0f} mmHg = {inspired:.0f} inspired - "
            f"{CO2_FACTOR:g} x {used:g} / {ventilation:.0f} mL/min/kg of ventilation; at least "
            f"{ALVEOLAR_MMHG:g} mmHg: raise oxygen_ratio, tidal_ml_per_kg or rate_per_min"
        )
    content = patient_preset.OXYGEN_ML_PER_G * values["haemoglobin_g_per_dl"] / patient_preset.DL_ML
    carried = patient_preset.LITRE_ML * values["output_l_per_min_per_kg"] * content
    if used > EXTRACTION * carried:
        raise InputError(
            f"oxygen_ml_per_min_per_kg {used:g} is more than {EXTRACTION:g} of the {carried:.1f} "
            f"mL/min/kg that blood carries ({values['output_l_per_min_per_kg']:g} L/min/kg with "
            f"{values['haemoglobin_g_per_dl']:g} g/dL)"
        )
