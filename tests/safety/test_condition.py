import itertools

import pytest

from opensuction.safety.condition import Condition, row_of
from opensuction.safety.condition_mask import TRIPS, decode_trips
from opensuction.safety.handling import PRIORITIES, Onset, Priority, Reaction, Severity

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
    "CHECK_FAILED WATCHDOG_FIRED CALIBRATION_OUT_OF_RANGE CARRIAGE_READING_INVALID LOCKED_OUT"
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
    C.LOCKED_OUT,
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
    assert [condition.name for condition in sorted(Condition)] == NUMBERS.split()
    assert sorted(Condition) == list(range(len(Condition)))


def test_every_condition_says_in_words_what_is_wrong_and_what_to_do() -> None:
    sentences = [condition.row.sentence for condition in Condition]
    assert len(set(sentences)) == len(sentences)
    for condition in Condition:
        sentence, remedy, _ = condition.row
        assert sentence[0].islower()
        assert not sentence.endswith(".")
        assert remedy[0].isupper()
        assert remedy.endswith(".")


@pytest.mark.parametrize(
    ("condition", "words"),
    [
        (C.RESERVE_ENERGY_USED, ("reserve energy, or none", "if it does not move")),
        (C.CONTACT_STUCK_CLOSED, ("the tip touches, or the switch sticks",)),
        (C.WITHDRAWAL_UNSEEN, ("was to be drawn out", "if it is still in the airway")),
        (C.TIP_DETACHED, ("or may have come off",)),
        (C.HEAD_SENSORS_DISAGREE, ("may still be inside",)),
    ],
    ids=lambda one: getattr(one, "name", None),
)
def test_what_is_told_is_no_more_than_is_known(condition: Condition, words: tuple[str]) -> None:
    """Where one sign stands for either of two things, both are named."""
    said = f"{condition.row.sentence}. {condition.row.remedy}"
    assert [one for one in words if one not in said] == []


def test_the_matrix_knows_every_pair_and_never_ranks_worse_harm_or_sooner_onset_lower() -> None:
    assert set(PRIORITIES) == set(itertools.product(Severity, Onset))
    for (severity, onset), (worse, sooner) in itertools.product(PRIORITIES, repeat=2):
        if worse >= severity and sooner >= onset:
            assert PRIORITIES[worse, sooner] >= PRIORITIES[severity, onset]
    assert PRIORITIES[Severity.DEATH, Onset.PROMPT] == Priority.HIGH
    assert PRIORITIES[Severity.DEATH, Onset.DELAYED] == Priority.MEDIUM
    assert PRIORITIES[Severity.REVERSIBLE, Onset.IMMEDIATE] == Priority.HIGH
    assert PRIORITIES[Severity.REVERSIBLE, Onset.PROMPT] == Priority.MEDIUM
    assert PRIORITIES[Severity.MINOR, Onset.IMMEDIATE] == Priority.MEDIUM
    assert PRIORITIES[Severity.REVERSIBLE, Onset.DELAYED] == Priority.LOW


@pytest.mark.requirement("OS-R30")
def test_priorities_are_those_of_the_hazard_list() -> None:
    ranked = {condition: condition.row.handling.priority for condition in Condition}
    assert {c for c in HIGH_IN_THE_HAZARD_LIST if ranked[c] != Priority.HIGH} == set()
    assert {c for c in MEDIUM_IN_THE_HAZARD_LIST if ranked[c] != Priority.MEDIUM} == set()
    assert ranked[C.CATHETER_LIFE_ENDING] == Priority.LOW


@pytest.mark.requirement("OS-R35")
def test_what_threatens_the_patient_is_never_a_consequence_of_planned_work() -> None:
    planned = {condition for condition in Condition if condition.row.handling.planned}
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


PATIENT = {condition for condition in C if C.SPO2_LOW <= condition <= C.MONITOR_LINK_LOST}
"""Seen by the patient's monitor."""
ALL_TRIPS = set(decode_trips(TRIPS))
OWN = set(Condition) - ALL_TRIPS
"""Conditions that are no trip."""


def test_of_the_trips_hands_in_the_machine_bring_about_only_those_of_readings_and_motion() -> None:
    # Out of service nothing is driven: a cable pulled or a head pushed by hand threatens nobody.
    # Vacuum, the host and impossible setpoints are nothing that cleaning changes.
    alarming = {
        C.PROPOSAL_INVALID,
        C.VACUUM_EXCEEDED,
        C.LATE_TICKS,
        C.DRIVE_OVERFORCE,
        C.VALVE_STUCK_OPEN,
        C.PUMP_RUNAWAY,
        C.TIP_DETACHED,
    }
    assert {code for code in ALL_TRIPS if not code.row.handling.planned} == alarming | PATIENT


def test_a_trip_is_announced_at_once_and_latches_but_for_the_patients_which_end_by_themselves() -> (
    None
):
    for code in ALL_TRIPS:
        assert code.row.handling.latching == (code not in PATIENT)
        assert code.row.handling.delay_s == 0.0


def test_delays_are_short_for_what_is_urgent_and_only_lower_priorities_escalate() -> None:
    for condition in Condition:
        handling = condition.row.handling
        assert 0.0 <= handling.delay_s <= 2.0
        assert handling.priority < Priority.HIGH or handling.delay_s <= 1.0
        assert handling.escalates_s == 0.0 or handling.priority < Priority.HIGH


def test_a_number_without_a_condition_alarms_as_urgently_as_can_be_and_has_words() -> None:
    sentence, remedy, handling = row_of(53)
    assert sentence == "unknown condition 53: the software is at fault"
    assert remedy == C.IN_AIRWAY_TIME.row.remedy
    assert (handling.severity, handling.onset) == (Severity.DEATH, Onset.IMMEDIATE)
    assert handling.latching
    assert not handling.planned
    assert (handling.delay_s, handling.escalates_s) == (0.0, 0.0)
    assert (handling.reaction, handling.cuts_vacuum) == (Reaction.PASS, False)
    assert row_of(int(C.SPO2_LOW)) == C.SPO2_LOW.row


def own(chosen: str) -> set[str]:
    """Names of own conditions for which a column of the table is not nothing."""
    return {code.name for code in OWN if getattr(code.row.handling, chosen)}


def test_an_own_condition_stays_for_a_person_where_its_cause_may_hide_again() -> None:
    assert own("latching") == {
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
        "LOCKED_OUT",
    }


def test_only_a_lost_recorder_or_console_is_waited_for_and_that_for_two_seconds() -> None:
    delays = {condition.name: condition.row.handling.delay_s for condition in Condition}
    waiting = {name: delay_s for name, delay_s in delays.items() if delay_s}
    assert waiting == {"RECORDER_LOST": 2.0, "CONSOLE_LOST": 2.0}


def test_a_medium_alarm_rises_after_two_minutes_and_the_ending_life_of_a_catheter_in_an_hour() -> (
    None
):
    # A catheter past its life keeps the machine from starting: nobody has to come at once.
    for condition in Condition:
        handling = condition.row.handling
        rises = handling.priority == Priority.MEDIUM and condition != C.CATHETER_LIFE_OVER
        seconds = 3600.0 if condition == C.CATHETER_LIFE_ENDING else 120.0 if rises else 0.0
        assert handling.escalates_s == seconds, condition.name


TORQUE_OFF = {
    # The head does the opposite of what it is told, or more of it: it is not asked to withdraw.
    "HEAD_OVERSPEED",
    "HEAD_RUNAWAY",
    # It has been pulled and did not come, or nobody knows whether it did: no more force.
    "WITHDRAWAL_TIME",
    "WITHDRAWAL_BLOCKED",
    "WITHDRAWAL_UNSEEN",
}
"""All other trips withdraw."""
VACUUM_KEPT = {
    "TIP_DETACHED",
    # Nothing is wrong with the suction; it stays as proposed on the way out.
    "CONTACT_READING_INVALID",
    # What hangs at the tip would be left in the airway.
    "LINE_CLOGGED",
}
"""All other trips cut it."""
MEDIUM = {
    # Suction serves nothing or cannot be seen, but it hurts nobody: prompt is enough.
    "CAM_READING_INVALID",
    "CARRIAGE_READING_INVALID",
    "VACUUM_READING_INVALID",
    "CONTACT_READING_INVALID",
    "CONTACT_STUCK_CLOSED",
    "VACUUM_LOST",
    "CANISTER_FULL",
    "LINE_CLOGGED",
    "LINE_LEAKING",
    "VALVE_STUCK_CLOSED",
    "LUNG_VOLUME_LOST",
    "MONITOR_LINK_LOST",
}
"""All other trips are of high priority."""
NO_TRIPS = {
    "AUTOMATION_STOPPED",
    "RECOVERY_NEEDED",
    "CATHETER_LIFE_OVER",
    "CATHETER_LIFE_ENDING",
    "RECORDER_LOST",
    "CONSOLE_LOST",
    "RESERVE_ENERGY_USED",
    "PATIENT_SETTINGS_UNCONFIRMED",
    "MESSAGE_LATE",
    "PASS_LIMIT_REACHED",
    "CHECK_FAILED",
    "WATCHDOG_FIRED",
    "CALIBRATION_OUT_OF_RANGE",
    "LOCKED_OUT",
}
"""The governor does nothing about them."""


@pytest.mark.parametrize("code", Condition, ids=lambda code: code.name)
def test_every_trip_comes_out_first_without_suction_unless_the_fault_demands_otherwise(
    code: Condition,
) -> None:
    handling = code.row.handling
    if code.name in NO_TRIPS:
        assert (handling.reaction, handling.cuts_vacuum) == (Reaction.PASS, False)
        return
    moves = code.name not in TORQUE_OFF
    assert handling.reaction == (Reaction.WITHDRAW if moves else Reaction.TORQUE_OFF)
    assert handling.cuts_vacuum == (code.name not in VACUUM_KEPT)
    assert handling.priority == (Priority.MEDIUM if code.name in MEDIUM else Priority.HIGH)


def test_numbers_of_priorities_and_reactions_in_recordings_keep_their_meaning() -> None:
    assert [(level.name, int(level)) for level in Priority] == [
        ("NONE", 0),
        ("LOW", 1),
        ("MEDIUM", 2),
        ("HIGH", 3),
    ]
    assert [(reaction.name, int(reaction)) for reaction in Reaction] == [
        ("PASS", 0),
        ("CAP", 1),
        ("HOLD", 2),
        ("WITHDRAW", 3),
        ("TORQUE_OFF", 4),
    ]
