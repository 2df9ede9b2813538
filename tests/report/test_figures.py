import pytest

from opensuction.report.figure import Figure, FigureVerdict
from opensuction.report.figures import figures
from opensuction.result.cycle_result import CycleResult
from tests.report import example


def _figure(summary: CycleResult, name: str) -> Figure:
    return next(figure for figure in figures(summary) if figure.name == name)


@pytest.mark.parametrize(
    ("lasted_s", "verdict"),
    [
        (12.0, FigureVerdict.GOOD),
        (15.0, FigureVerdict.GOOD),
        (20.4, FigureVerdict.NOTICE),
        (24.1, FigureVerdict.BAD),
    ],
)
def test_suction_time_is_held_against_guideline_and_protocol(
    lasted_s: float, verdict: FigureVerdict
) -> None:
    timing = example.SUMMARY["timing"] | {"negative_pressure_s": lasted_s}
    figure = _figure(example.summary(timing=timing), "Time under negative pressure")
    assert figure.verdict is verdict
    assert figure.limit == "limit 24.0 s, guideline 15.0 s"


@pytest.mark.parametrize(
    ("deepest_mm", "verdict"),
    [(95.0, FigureVerdict.GOOD), (95.01, FigureVerdict.BAD), (None, FigureVerdict.ABSENT)],
)
def test_deepest_tip_is_held_against_the_cap(
    deepest_mm: float | None, verdict: FigureVerdict
) -> None:
    tip = example.SUMMARY["tip"] | {"deepest_mm": deepest_mm}
    assert _figure(example.summary(tip=tip), "Deepest tip position").verdict is verdict


def test_a_verdict_that_needs_a_look_is_also_in_words() -> None:
    tip = example.SUMMARY["tip"] | {"stop_error_mm": -20.0, "deepest_mm": 99.0}
    for figure in figures(example.summary(tip=tip)):
        if figure.verdict in (FigureVerdict.GOOD, FigureVerdict.NOTICE, FigureVerdict.BAD):
            assert figure.remark


def test_what_was_not_simulated_is_no_number() -> None:
    figure = _figure(example.summary(), "Lowest oxygen saturation")
    assert figure.value == "not simulated"
    assert figure.verdict is FigureVerdict.ABSENT


def test_summary_without_anything_has_only_absent_figures() -> None:
    assert {figure.verdict for figure in figures(example.cycle({}))} == {FigureVerdict.ABSENT}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("Lowest oxygen saturation", "91.4 %"),
        ("Lung volume lost", "412 mL"),
        ("Airway pressure", "-2.3 cmH2O"),
    ],
)
def test_what_suction_did_to_the_patient_is_a_key_figure(name: str, value: str) -> None:
    figure = _figure(example.on_patient(), name)
    assert (figure.value, figure.verdict) == (value, FigureVerdict.NEUTRAL)


def test_touching_the_carina_needs_a_look_only_where_it_was_not_wanted() -> None:
    wanted = _figure(example.on_patient(), "Force on the carina")
    unwanted = _figure(example.on_patient(approach="travel"), "Force on the carina")
    assert (wanted.verdict, unwanted.verdict) == (FigureVerdict.NEUTRAL, FigureVerdict.NOTICE)


@pytest.mark.parametrize(
    ("error_mm", "verdict"),
    [(0.4, FigureVerdict.GOOD), (10.5, FigureVerdict.BAD), (-10.5, FigureVerdict.NOTICE)],
)
def test_suction_on_the_carina_is_no_good_stop(error_mm: float, verdict: FigureVerdict) -> None:
    tip = example.ON_PATIENT["tip"] | {"stop_error_mm": error_mm}
    figure = _figure(example.on_patient(tip=tip), "Stopping error")
    assert figure.verdict is verdict
    assert "margin to the carina 10.0 mm" in figure.limit


@pytest.mark.parametrize(
    ("name", "key", "changes", "verdict"),
    [
        ("Lowest oxygen saturation", "spo2_percent", {}, FigureVerdict.GOOD),
        ("Lowest oxygen saturation", "spo2_percent", {"lowest": 86.4}, FigureVerdict.NOTICE),
        ("Lowest oxygen saturation", "spo2_percent", {"lowest": 43.0}, FigureVerdict.BAD),
        ("Lowest heart rate", "heart_rate_per_min", {"lowest": 60.0}, FigureVerdict.NOTICE),
        ("Lowest heart rate", "heart_rate_per_min", {"lowest": 49.0}, FigureVerdict.BAD),
        ("Airway pressure", "airway_pressure_cmh2o", {"lowest": 0.0}, FigureVerdict.NOTICE),
        ("Airway pressure", "airway_pressure_cmh2o", {"highest": 46.6}, FigureVerdict.NOTICE),
    ],
)
def test_a_vital_sign_outside_its_range_is_not_green(
    name: str, key: str, changes: dict[str, float], verdict: FigureVerdict
) -> None:
    summary = example.on_patient(vitals=example.vitals(key, **changes))
    assert _figure(summary, name).verdict is verdict


def test_a_cough_is_no_airway_pressure_that_the_machine_made() -> None:
    coughed = {"highest": 68.1, "relaxed_lowest": 3.2, "relaxed_highest": 16.2}
    summary = example.on_patient(vitals=example.vitals("airway_pressure_cmh2o", **coughed))
    shown = _figure(summary, "Airway pressure")
    assert shown.verdict is FigureVerdict.GOOD
    assert shown.remark == "within its range but for the patient's own cough or breath"
    assert shown.value.endswith("68.1 cmH2O")
    # What is out of it without the patient's muscles, too, is not the patient's own.
    forced = example.vitals("airway_pressure_cmh2o", **(coughed | {"relaxed_highest": 46.6}))
    shown = _figure(example.on_patient(vitals=forced), "Airway pressure")
    assert shown.verdict is FigureVerdict.NOTICE
    assert "46.6 cmH2O is over the usual" in shown.remark


def test_a_vital_sign_says_what_it_was_and_when_it_was_back() -> None:
    shown = _figure(example.on_patient(vitals=example.VITALS), "Lowest oxygen saturation")
    assert shown.limit == "before 96.1 %, at the end 95.4 %: back after 71 s"
    lost = example.vitals("spo2_percent", is_back=False, recovered_s=None)
    shown = _figure(example.on_patient(vitals=lost), "Lowest oxygen saturation")
    assert shown.limit == "before 96.1 %, at the end 95.4 %: not back yet"


def test_more_lung_volume_than_closed_suction_takes_is_amber() -> None:
    lost = example.on_patient(vitals=example.VITALS, lung_volume_loss_ml=576.0)
    assert _figure(lost, "Lung volume lost").verdict is FigureVerdict.NOTICE
    usual = example.on_patient(vitals=example.VITALS)
    assert _figure(usual, "Lung volume lost").verdict is FigureVerdict.GOOD


@pytest.mark.parametrize(("percent", "verdict"), [(49.0, "notice"), (51.0, "good")])
def test_a_clearance_under_half_is_amber(percent: float, verdict: str) -> None:
    secretion = {"removed_ml": 1.0, "removed_percent": percent}
    figure = _figure(example.summary(secretion=secretion), "Secretions removed")
    assert figure.verdict.value == verdict


def test_a_tip_in_a_bronchus_is_never_within_its_cap() -> None:
    tip = example.ON_PATIENT["tip"] | {"deepest_mm": 109.8}  # carina 100, search to 113
    figure = _figure(example.on_patient(tip=tip), "Deepest tip position")
    assert figure.verdict is FigureVerdict.BAD
    assert figure.remark == "9.8 mm past the carina"


def test_an_alarm_takes_the_green_from_a_figure_that_is_within_its_limit() -> None:
    alarm = example.ALARM | {"condition": "negative-pressure-time"}
    figure = _figure(example.good(alarms=[alarm]), "Time under negative pressure")
    assert figure.verdict is FigureVerdict.NOTICE
    assert figure.remark == f"alarm: {alarm['sentence']}"
