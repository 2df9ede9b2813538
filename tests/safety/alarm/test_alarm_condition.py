import itertools

import pytest

from opensuction.kernel.row import columns
from opensuction.safety import trip
from opensuction.safety.alarm import alarm_clock, alarm_condition, alarm_text
from opensuction.safety.alarm.alarm_condition import (
    KINDS,
    PRIORITIES,
    WORD,
    Condition,
    Harm,
    Onset,
    Priority,
    mask,
    members,
)
from opensuction.safety.alarm.alarm_state import Signals
from opensuction.safety.trip import Trip

C = Condition

NUMBERS = (
    "PROPOSAL_INVALID HEAD_READING_INVALID HEAD_OVERSPEED HEAD_NOT_FOLLOWING CAM_READING_INVALID "
    "VACUUM_READING_INVALID VACUUM_EXCEEDED NEGATIVE_PRESSURE_TIME IN_AIRWAY_TIME CONTACT_TIME "
    "CONTACT_READING_INVALID LATE_TICKS WITHDRAWAL_TIME HEAD_STALLED HEAD_RUNAWAY TIP_BEYOND_CAP "
    "WITHDRAWAL_BLOCKED WITHDRAWAL_UNSEEN DRIVE_OVERFORCE HEAD_SENSORS_DISAGREE "
    "AUTOMATION_STOPPED RECOVERY_NEEDED CATHETER_LIFE_OVER CATHETER_LIFE_ENDING "
    "VACUUM_LOST CANISTER_FULL LINE_CLOGGED LINE_LEAKING CARINA_MISSED CONTACT_STUCK_CLOSED "
    "CONTACT_STUCK_OPEN VALVE_STUCK_OPEN VALVE_STUCK_CLOSED PUMP_RUNAWAY CATHETER_JAMMED "
    "TIP_DETACHED SPO2_LOW HEART_RATE_LOW AIRWAY_PRESSURE_UNSAFE "
    "LUNG_VOLUME_LOST CIRCUIT_DISCONNECTED MONITOR_LINK_LOST RECORDER_LOST CONSOLE_LOST "
    "RESERVE_ENERGY_USED PATIENT_SETTINGS_UNCONFIRMED MESSAGE_LATE PASS_LIMIT_REACHED "
    "CHECK_FAILED WATCHDOG_FIRED CALIBRATION_OUT_OF_RANGE CARRIAGE_READING_INVALID"
)
"""In order of their numbers. Recordings hold these: add a new one, never renumber an old one."""

HIGH_IN_THE_HAZARD_LIST = {
    C.CARINA_MISSED,
    C.CONTACT_STUCK_OPEN,
    C.VALVE_STUCK_OPEN,
    C.VACUUM_EXCEEDED,
    C.PUMP_RUNAWAY,
    C.CATHETER_JAMMED,
    C.TIP_DETACHED,
    C.SPO2_LOW,
    C.HEART_RATE_LOW,
    C.AIRWAY_PRESSURE_UNSAFE,
    C.CIRCUIT_DISCONNECTED,
    C.RESERVE_ENERGY_USED,
    C.RECOVERY_NEEDED,
    C.WATCHDOG_FIRED,
    C.MESSAGE_LATE,
    C.IN_AIRWAY_TIME,
    C.WITHDRAWAL_TIME,
}
MEDIUM_IN_THE_HAZARD_LIST = {
    C.CONTACT_STUCK_CLOSED,
    C.VALVE_STUCK_CLOSED,
    C.VACUUM_LOST,
    C.CANISTER_FULL,
    C.LINE_LEAKING,
    C.LINE_CLOGGED,
    C.MONITOR_LINK_LOST,
    C.PASS_LIMIT_REACHED,
    C.CATHETER_LIFE_OVER,
    C.AUTOMATION_STOPPED,
}


def test_numbers_in_recordings_keep_their_meaning() -> None:
    names = NUMBERS.split()
    for number, name in enumerate(names):
        assert name == "-" or Condition[name] == number
    assert len(Condition) == sum(name != "-" for name in names)


@pytest.mark.parametrize("code", Trip)
def test_each_trip_is_one_condition_of_the_same_number_name_and_priority(code: Trip) -> None:
    assert Condition(int(code)).name == code.name
    assert KINDS[Condition(int(code))].priority.name.lower() == trip.KINDS[code].priority
    # What is wrong with the patient ends with its cause, but for what the governor holds.
    assert KINDS[Condition(int(code))].latching or Trip.SPO2_LOW <= code <= Trip.MONITOR_LINK_LOST
    assert KINDS[Condition(int(code))].delay_s == 0.0


def test_no_condition_has_two_kinds_or_two_texts() -> None:
    trips = {Condition(int(code)) for code in Trip}
    assert {code for code in Condition if code < C.AUTOMATION_STOPPED} <= trips
    assert set(alarm_condition.OWN_KINDS) & trips == set()
    assert set(alarm_text.OWN_TEXTS) & trips == set()


def test_every_condition_has_a_kind_and_a_text_of_its_own() -> None:
    assert set(KINDS) == set(Condition)
    assert set(alarm_text.TEXTS) == set(Condition)
    sentences = [text.sentence for text in alarm_text.TEXTS.values()]
    assert len(set(sentences)) == len(sentences)
    for text in alarm_text.TEXTS.values():
        assert text.sentence[0].islower()
        assert not text.sentence.endswith(".")
        assert text.remedy[0].isupper()
        assert text.remedy.endswith(".")


def test_the_matrix_knows_every_pair_and_never_ranks_worse_harm_or_sooner_onset_lower() -> None:
    assert set(PRIORITIES) == set(itertools.product(Harm, Onset))
    for (harm, onset), (worse, sooner) in itertools.product(PRIORITIES, repeat=2):
        if worse >= harm and sooner >= onset:
            assert PRIORITIES[worse, sooner] >= PRIORITIES[harm, onset]
    assert PRIORITIES[Harm.DEATH, Onset.PROMPT] == Priority.HIGH
    assert PRIORITIES[Harm.DEATH, Onset.DELAYED] == Priority.MEDIUM
    assert PRIORITIES[Harm.REVERSIBLE, Onset.IMMEDIATE] == Priority.HIGH
    assert PRIORITIES[Harm.REVERSIBLE, Onset.PROMPT] == Priority.MEDIUM
    assert PRIORITIES[Harm.MINOR, Onset.IMMEDIATE] == Priority.MEDIUM
    assert PRIORITIES[Harm.REVERSIBLE, Onset.DELAYED] == Priority.LOW


@pytest.mark.requirement("OS-R30")
def test_priorities_are_those_of_the_hazard_list() -> None:
    assert {c for c in HIGH_IN_THE_HAZARD_LIST if KINDS[c].priority != Priority.HIGH} == set()
    assert {c for c in MEDIUM_IN_THE_HAZARD_LIST if KINDS[c].priority != Priority.MEDIUM} == set()
    assert KINDS[C.CATHETER_LIFE_ENDING].priority == Priority.LOW


@pytest.mark.requirement("OS-R35")
def test_what_threatens_the_patient_is_never_a_consequence_of_planned_work() -> None:
    planned = {code for code, kind in KINDS.items() if kind.planned}
    assert {C.CATHETER_LIFE_OVER, C.CATHETER_LIFE_ENDING, C.AUTOMATION_STOPPED} <= planned
    assert C.CHECK_FAILED in planned
    spared = {
        C.SPO2_LOW,
        C.HEART_RATE_LOW,
        C.AIRWAY_PRESSURE_UNSAFE,
        C.CIRCUIT_DISCONNECTED,
        C.MONITOR_LINK_LOST,
        C.TIP_DETACHED,
        C.VALVE_STUCK_OPEN,
        C.PUMP_RUNAWAY,
        C.RESERVE_ENERGY_USED,
    }
    assert planned & spared == set()


def test_of_the_trips_hands_in_the_machine_bring_about_only_those_of_readings_and_motion() -> None:
    # Out of service nothing is driven: a cable pulled or a head pushed by hand threatens nobody.
    # Vacuum, the host and impossible setpoints are nothing that cleaning changes.
    alarming = {
        Trip.PROPOSAL_INVALID,
        Trip.VACUUM_EXCEEDED,
        Trip.LATE_TICKS,
        Trip.DRIVE_OVERFORCE,
        Trip.VALVE_STUCK_OPEN,
        Trip.PUMP_RUNAWAY,
    }
    alarming |= {code for code in Trip if Trip.SPO2_LOW <= code <= Trip.MONITOR_LINK_LOST}
    assert {code for code in Trip if not KINDS[Condition(int(code))].planned} == alarming


def test_delays_are_short_for_what_is_urgent_and_only_lower_priorities_escalate() -> None:
    for kind in KINDS.values():
        assert 0.0 <= kind.delay_s <= 2.0
        assert kind.priority < Priority.HIGH or kind.delay_s <= 1.0
        assert kind.escalates_s == 0.0 or kind.priority < Priority.HIGH
        assert kind.priority != Priority.MEDIUM or kind.escalates_s in (0.0, 120.0)
    assert KINDS[C.AUTOMATION_STOPPED].escalates_s == 120.0


def test_a_mask_survives_a_recording_where_every_number_is_a_double() -> None:
    everything = alarm_condition.KNOWN
    assert int(float(everything)) == everything
    assert max(Condition) < WORD
    assert {"present", "latched", "acknowledged"} <= set(columns(Signals))


def test_every_bit_has_one_priority_and_one_that_no_condition_has_is_high_and_latching() -> None:
    high, medium, low = alarm_condition.HIGHS, alarm_condition.MEDIUMS, alarm_condition.LOWS
    assert high + medium + low == alarm_condition.KNOWN == high | medium | low
    nobodys = alarm_condition.KNOWN & ~mask(set(Condition))
    assert nobodys != 0
    assert nobodys & ~high == 0
    assert nobodys & ~alarm_condition.LATCHING == 0
    assert nobodys & alarm_condition.PLANNED == 0


def test_a_mask_is_read_back() -> None:
    chosen = {C.SPO2_LOW, C.PROPOSAL_INVALID, C.WATCHDOG_FIRED}
    assert members(mask(chosen)) == sorted(chosen)
    assert members(0) == []


def test_a_number_without_a_condition_still_has_words() -> None:
    assert "unknown condition 52" in alarm_text.text(52).sentence
    assert alarm_text.text(int(C.SPO2_LOW)) == alarm_text.TEXTS[C.SPO2_LOW]


OWN = set(Condition) - {Condition(int(code)) for code in Trip}
"""Conditions that are no trip."""


def own(chosen: str) -> set[str]:
    """Names of own conditions for which a column of the table is not nothing."""
    return {code.name for code in OWN if getattr(KINDS[code], chosen)}


def test_an_own_condition_stays_for_a_person_where_its_cause_may_hide_again() -> None:
    assert own("latching") == {
        "TIP_DETACHED",
        "MESSAGE_LATE",
        "WATCHDOG_FIRED",
        "CALIBRATION_OUT_OF_RANGE",
    }


def test_planned_work_brings_about_what_a_person_at_the_machine_does() -> None:
    assert own("planned") == {
        "AUTOMATION_STOPPED",
        "CATHETER_LIFE_OVER",
        "CATHETER_LIFE_ENDING",
        "PATIENT_SETTINGS_UNCONFIRMED",
        "MESSAGE_LATE",
        "CHECK_FAILED",
    }


def test_only_a_lost_recorder_or_console_is_waited_for_and_that_for_two_seconds() -> None:
    waiting = {code.name: kind.delay_s for code, kind in KINDS.items() if kind.delay_s}
    assert waiting == {"RECORDER_LOST": 2.0, "CONSOLE_LOST": 2.0}


def test_a_medium_alarm_rises_after_two_minutes_and_the_ending_life_of_a_catheter_in_an_hour() -> (
    None
):
    # A catheter past its life keeps the machine from starting: nobody has to come at once.
    for code, kind in KINDS.items():
        rises = kind.priority == Priority.MEDIUM and code != C.CATHETER_LIFE_OVER
        seconds = 3600.0 if code == C.CATHETER_LIFE_ENDING else 120.0 if rises else 0.0
        assert kind.escalates_s == seconds, code.name


def test_the_compiled_step_reads_the_same_table() -> None:
    for code, kind in KINDS.items():
        assert (code in alarm_clock.DELAYED) == (kind.delay_s > 0.0)
        assert (code in alarm_clock.RISING) == (kind.escalates_s > 0.0)
        assert (alarm_condition.LATCHING >> code & 1) == kind.latching
        assert (alarm_condition.PLANNED >> code & 1) == kind.planned
    assert WORD - 1 not in (*KINDS, *alarm_clock.DELAYED, *alarm_clock.RISING)
    assert {level.name: int(level) for level in Priority} == {
        "NONE": 0,
        "LOW": 1,
        "MEDIUM": 2,
        "HIGH": 3,
    }
