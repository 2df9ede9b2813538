import math

import pytest

from opensuction.report import headline, narrative
from tests.report import example


def test_completed_cycle_is_told_with_its_limits() -> None:
    told = " ".join(narrative.sentences(example.summary()))
    assert "90.7 mm below the end of the tube, 4.3 mm short of the cap of 95.0 mm" in told
    assert "within 0.5 mm of its target (90.0 mm)" in told
    assert "20.4 s: over the guideline's limit of 15 s, within the protocol's limit of 24 s" in told
    assert "2.5 mL of secretions, 84 % of what was there" in told
    assert "did not touch the carina" in told
    assert "No safety limit tripped and no alarm was raised." in told


def test_protocol_that_allows_what_the_guideline_does_is_said_once() -> None:
    timing = {"negative_pressure_s": 14.5, "negative_pressure_budget_s": 15.0, "guideline_s": 15.0}
    told = narrative.sentences(example.summary(timing=timing))
    assert "Suction lasted 14.5 s: within the limit of guideline and protocol of 15 s." in told


def test_aborted_cycle_begins_with_when_and_why() -> None:
    summary = example.aborted()
    first = narrative.sentences(summary)[0]
    assert first == "The cycle was aborted after 17.0 s: the line vacuum is above its limit."


def test_abort_without_a_trip_was_a_person() -> None:
    summary = example.aborted(trips=[], alarms=[])
    assert "a person asked for it" in narrative.sentences(summary)[0]


def test_trip_of_a_completed_cycle_is_not_hidden() -> None:
    told = " ".join(narrative.sentences(example.summary(trips=[example.TRIP])))
    assert "the line vacuum is above its limit" in told
    assert "No safety limit" not in told


@pytest.mark.parametrize(
    ("error_mm", "said"),
    [(-20.3, "20.3 mm short of its target"), (6.0, "6.0 mm beyond its target")],
)
def test_missed_target_is_said(error_mm: float, said: str) -> None:
    tip = example.SUMMARY["tip"] | {"stop_error_mm": error_mm}
    summary = example.summary(tip=tip)
    assert said in " ".join(narrative.sentences(summary))
    assert "stopping error" in headline.headline(summary).lead.lower()


def test_tip_past_its_cap_is_said() -> None:
    tip = example.SUMMARY["tip"] | {"deepest_mm": 95.4}
    told = " ".join(narrative.sentences(example.summary(tip=tip)))
    assert "0.4 mm past the cap of 95.0 mm" in told


def test_pressing_on_the_carina_is_said_with_its_force() -> None:
    told = " ".join(narrative.sentences(example.summary(carina_force_peak_n=0.214)))
    assert "touched the carina with at most 0.21 N." in told


@pytest.mark.parametrize(
    "key", ["tip", "timing", "secretion", "anatomy", "carina_force_peak_n", "phases", "trips"]
)
def test_nothing_is_invented_where_a_value_is_missing(key: str) -> None:
    for summary in (example.summary(**{key: None}), example.aborted(**{key: None})):
        told = " ".join(narrative.sentences(summary))
        assert "None" not in told
        assert "nan" not in told


def test_value_that_is_not_a_number_is_not_told() -> None:
    summary = example.summary(carina_force_peak_n=math.nan)
    assert "carina" not in " ".join(narrative.sentences(summary))


def test_patient_is_told_in_plain_words() -> None:
    told = narrative.sentences(example.on_patient())
    assert (
        "The lungs lost up to 412 mL of their resting volume; the lowest airway pressure was "
        "-2.3 cmH2O, below the air outside."
    ) in told
    assert told[0] == "Oxygen saturation was 91.4 % at its lowest."
    assert "saturation" not in " ".join(narrative.sentences(example.summary()))


def test_a_breath_of_the_patients_own_is_told_beside_what_suction_did() -> None:
    vitals = {"airway_pressure_cmh2o": {"lowest": -3.7}}
    told = " ".join(narrative.sentences(example.on_patient(vitals=vitals)))
    assert "-3.7 cmH2O in a breath of the patient's own" in told
    assert "of the patient's own" not in " ".join(narrative.sentences(example.on_patient()))


def test_contact_is_told_with_its_force_and_the_way_back() -> None:
    told = narrative.sentences(example.on_patient())
    touched = "The tip touched the carina with at most 0.14 N"
    assert f"{touched} and backed off by 10.3 mm before suction." in told


def test_spring_of_the_tip_is_no_backing_off() -> None:
    tip = example.ON_PATIENT["tip"] | {"deepest_mm": 90.42}  # reached: 90.4
    told = " ".join(narrative.sentences(example.on_patient(tip=tip)))
    assert "touched the carina with at most 0.14 N." in told


def test_contact_without_a_way_back_claims_none() -> None:
    told = " ".join(narrative.sentences(example.on_patient(phases=example.SUMMARY["phases"])))
    assert "touched the carina with at most 0.14 N." in told


@pytest.mark.parametrize(
    ("deepest_mm", "said"), [(-95.0, "did not enter the tube"), (-40.0, "did not leave the tube")]
)
def test_tip_that_came_not_far_is_said(deepest_mm: float, said: str) -> None:
    tip = {"deepest_mm": deepest_mm}
    assert said in " ".join(narrative.sentences(example.on_patient(tip=tip)))


def test_abort_that_halts_at_once_still_says_when_and_why() -> None:
    abort = {"event": "phase-overdue", "phase": "checking", "sentence": "it took too long"}
    summary = example.on_patient(outcome="aborted", phases=[], abort=abort | {"time_s": 3.2})
    first = narrative.sentences(summary)[0]
    assert first == "The cycle was aborted after 3.2 s: it took too long."


FAULT = {
    "name": "line-leak",
    "meaning": "air leaks into line or canister",
    "at_s": 12.0,
    "strength": 2.0,
    "strength_unit": "mL/s/mmHg",
    "noticed": {"sentence": "the line vacuum is above its limit", "after_s": 0.25},
}


def test_an_injected_fault_is_told_first_with_what_noticed_it() -> None:
    told = narrative.sentences(example.aborted(faults=[FAULT]))[0]
    assert told == (
        "Injected fault: line-leak (2 mL/s/mmHg) at 12.0 s, air leaks into line or canister. "
        "It was noticed 0.250 s later: the line vacuum is above its limit."
    )


def test_a_fault_that_nothing_noticed_is_told_so() -> None:
    faults = [FAULT | {"noticed": None}, FAULT | {"at_s": None}]
    told = narrative.sentences(example.summary(faults=faults))[0]
    assert told.endswith(
        "air leaks into line or canister. Nothing noticed it. "
        "The fault line-leak was to be injected, but its instant never came."
    )


def test_a_start_that_was_refused_is_not_told_as_a_person_s_wish() -> None:
    refused = FAULT | {"noticed": {"sentence": "the start was refused", "after_s": 0.0}}
    summary = example.aborted(trips=[], alarms=[], faults=[refused])
    assert headline.headline(summary).lead.startswith("The start was refused.")


@pytest.mark.parametrize(
    ("state", "said"),
    [
        ("confirmed", "a person confirmed it"),
        ("skipped", "asked for and skipped"),
        ("not-required", "asks for no pre-oxygenation"),
    ],
)
def test_pre_oxygenation_is_told_as_it_is_on_record(state: str, said: str) -> None:
    summary = example.on_patient(preoxygenation={"required": True, "state": state})
    assert said in " ".join(narrative.sentences(summary))
    assert "oxygenation was" not in " ".join(narrative.sentences(example.on_patient()))


def _poor(removed_ml: float, percent: float, **changes: object) -> str:
    secretion = {"removed_ml": removed_ml, "removed_percent": percent}
    return " ".join(narrative.sentences(example.summary(secretion=secretion, **changes)))


def test_less_than_half_offers_the_next_pass_within_three() -> None:
    offer = "the next pass may follow after the patient's rest, 3 in all at most"
    assert offer in _poor(0.9, 44.0)
    assert offer not in _poor(1.6, 55.0)
    assert offer not in _poor(0.9, 44.0, outcome="aborted")
    assert offer not in _poor(0.9, 44.0, harm=["saturation"])
    limit = example.ALARM | {"condition": "pass-limit-reached", "priority": "medium"}
    told = _poor(0.9, 44.0, alarms=[limit])
    assert offer not in told
    assert "the permitted number is reached" in told


def test_a_pass_that_drew_nothing_is_not_simply_repeated() -> None:
    told = _poor(0.0, 0.0)
    assert "look for a clog or a leak from the tip to the pump before another pass" in told


def test_a_longer_stay_than_hands_are_allowed_has_its_reason() -> None:
    timing = example.GOOD["timing"] | {"in_airway_guideline_s": 15.0, "in_airway_budget_s": 30.0}
    told = " ".join(narrative.sentences(example.on_patient(timing=timing)))
    assert "for 29.0 s, over the 15 s from insertion to removal of [ACI-2014]: by design" in told


def test_what_followed_from_the_drives_is_not_the_cause() -> None:
    told = [example.told("watchdog-fired", "drives", at_s=16.8)]
    first = narrative.sentences(example.aborted(told=told))[0]
    assert first == "The cycle was aborted after 17.0 s: watchdog fired."


def test_an_alarm_that_the_annunciator_did_not_show_is_told_so() -> None:
    sentences = " ".join(narrative.sentences(example.aborted(told=[])))
    assert "Not all of them were shown at the bedside" in sentences


def test_alarms_of_the_power_supply_alone_are_no_silence() -> None:
    told = [example.told("reserve-energy-used", "power")]
    sentences = " ".join(narrative.sentences(example.good(told=told)))
    assert "One alarm was raised, by the power supply, not by the controller." in sentences


def test_it_says_when_suction_ended_because_nothing_came() -> None:
    timing = example.GOOD["timing"] | {"dwell_s": 2.1, "nothing_comes_s": 0.75}
    ended = example.summary(timing=timing | {"dwell_ended_by": "nothing-came"})
    said = "Suction at depth ended after 2.1 s: nothing came for 0.75 s."
    assert said in narrative.sentences(ended)
    whole = example.summary(timing=timing | {"dwell_ended_by": "dwell-elapsed"})
    assert not any("nothing came" in one for one in narrative.sentences(whole))
