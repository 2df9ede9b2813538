from typing import Any

import pytest

from opensuction.report import headline, narrative
from opensuction.report.figure import FigureVerdict
from tests.report import example

MEDIUM = example.ALARM | {
    "condition": "canister-full",
    "priority": "medium",
    "sentence": "the canister is full",
    "remedy": "Change the canister.",
}
DISCONNECTED = example.ALARM | {
    "condition": "circuit-disconnected",
    "sentence": "the breathing circuit is disconnected",
    "remedy": "Reconnect the circuit.",
    "started_s": 18.0,
}
STOPPED = MEDIUM | {"condition": "automation-stopped", "sentence": "automatic suction has stopped"}
INSIDE = example.SUMMARY["tip"] | {"end_mm": 48.63, "inside_at_end": True}
BROKEN = {"name": "saturation", "worst": 43.21, "limit": 83.0, "unit": "%"}


@pytest.mark.parametrize(
    ("end_mm", "where"),
    [(48.63, "48.6 mm below the tube's end"), (-20.04, "20.0 mm above the tube's end")],
)
def test_a_catheter_left_inside_comes_before_all_else(end_mm: float, where: str) -> None:
    tip = INSIDE | {"end_mm": end_mm}
    harmed = example.summary(harm=["saturation"], alarms=[MEDIUM], tip=tip)
    for result in (example.aborted(tip=tip), harmed):
        found = headline.headline(result)
        assert found.text == f"CATHETER IS STILL IN THE AIRWAY, {where}: draw it out by the handle"
        assert found.verdict is FigureVerdict.BAD


def test_of_a_catheter_left_inside_in_silence_it_is_said_that_nobody_was_told() -> None:
    found = headline.headline(example.good(tip=INSIDE))
    assert found.lead == "Nobody was told: no alarm was raised. Completed."


def test_a_broken_bound_comes_before_the_most_urgent_alarm() -> None:
    summary = example.on_patient(
        harm=["saturation", "lung-volume"], broken_bounds=[BROKEN], alarms=[MEDIUM]
    )
    found = headline.headline(summary)
    assert found.text == (
        "PATIENT AT RISK: oxygen saturation fell below its bound (43.2 %, bound 83 %)"
    )
    assert found.verdict is FigureVerdict.BAD
    assert found.lead == (
        "Look at the patient. Give oxygen. Also: the lungs lost more volume than their bound. "
        "Medium alarm: the canister is full. Completed."
    )


def test_a_disconnection_stands_beside_the_bound_that_it_broke() -> None:
    found = headline.headline(example.on_patient(harm=["saturation"], alarms=[DISCONNECTED]))
    assert found.text.endswith("; the breathing circuit is disconnected")


def test_the_most_urgent_alarm_leads_and_not_the_first() -> None:
    early = example.ALARM | {"started_s": 1.0, "sentence": "the drive is too strong"}
    alarms = [MEDIUM | {"started_s": 0.5}, early, STOPPED, DISCONNECTED]
    found = headline.headline(example.aborted(alarms=alarms))
    assert found.text == "High alarm: the breathing circuit is disconnected"
    assert found.lead.startswith("Reconnect the circuit. Aborted at 17.0 s.")


def test_a_consequence_never_leads_before_its_cause() -> None:
    found = headline.headline(example.aborted(alarms=[STOPPED, MEDIUM]))
    assert found.text == "Medium alarm: the canister is full"


def test_an_alarm_of_the_power_supply_is_an_alarm() -> None:
    told = [example.told("reserve-energy-used", "power")]
    found = headline.headline(example.aborted(trips=[], alarms=[], told=told))
    assert found.text == "High alarm: reserve energy used"


@pytest.mark.parametrize(
    ("alarm", "text", "verdict"),
    [
        (MEDIUM, "Completed with alarms: the canister is full", FigureVerdict.NOTICE),
        (
            DISCONNECTED,
            "High alarm: the breathing circuit is disconnected",
            FigureVerdict.BAD,
        ),
        (
            DISCONNECTED | {"ended_s": 19.0},
            "High alarm, over since 19.0 s: the breathing circuit is disconnected",
            FigureVerdict.BAD,
        ),
    ],
)
def test_a_completed_cycle_with_alarms(
    alarm: dict[str, Any], text: str, verdict: FigureVerdict
) -> None:
    found = headline.headline(example.good(alarms=[alarm]))
    assert (found.text, found.verdict) == (text, verdict)
    assert "Completed with alarms" in f"{found.text} {found.lead}"


def test_a_completed_cycle_with_nothing_to_look_at_is_green() -> None:
    found = headline.headline(example.good())
    assert (found.text, found.verdict) == ("Completed", FigureVerdict.GOOD)
    assert found.lead == "Every figure is within the limit that was set for it."


def test_a_fall_of_saturation_that_is_no_broken_bound_is_still_a_figure_to_look_at() -> None:
    vitals = example.vitals("spo2_percent", lowest=86.4, at_end=86.7, is_back=False)
    timing = example.GOOD["timing"]
    tip = example.ON_PATIENT["tip"]
    found = headline.headline(example.on_patient(vitals=vitals, timing=timing, tip=tip))
    assert found.verdict is FigureVerdict.NOTICE
    assert found.text == "Completed, look at lowest oxygen saturation (86.4 %)"
    assert found.lead == "Lowest oxygen saturation 86.4 %, below the usual 88.0 %."


def test_a_fault_that_nothing_noticed_is_not_passed_over() -> None:
    fault = {"name": "tip-detached", "at_s": 15.0, "noticed": None}
    found = headline.headline(example.good(faults=[fault]))
    assert found.text == "Completed, and nothing noticed the fault tip-detached"
    assert found.verdict is FigureVerdict.NOTICE
    told = [example.told("tip-detached", "drives", at_s=16.0)]
    noticed = example.good(faults=[fault], told=told)
    assert "Nothing noticed it" not in " ".join(narrative.sentences(noticed))


def test_a_person_who_stops_a_cycle_is_told_that_it_was_a_person() -> None:
    found = headline.headline(example.aborted(trips=[], alarms=[]))
    assert found.text == "Aborted at 17.0 s"
    assert found.lead.startswith("A person asked for it, no safety limit tripped.")
