from collections.abc import Collection

import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.safety import trip
from opensuction.safety.trip import KINDS, Reaction, Trip

trips = st.sets(st.sampled_from(Trip))

NUMBERS = {
    "PROPOSAL_INVALID": 0,
    "HEAD_READING_INVALID": 1,
    "HEAD_OVERSPEED": 2,
    "HEAD_NOT_FOLLOWING": 3,
    "CAM_READING_INVALID": 4,
    "VACUUM_READING_INVALID": 5,
    "VACUUM_EXCEEDED": 6,
    "NEGATIVE_PRESSURE_TIME": 7,
    "IN_AIRWAY_TIME": 8,
    "CONTACT_TIME": 9,
    "CONTACT_READING_INVALID": 10,
    "LATE_TICKS": 11,
    "WITHDRAWAL_TIME": 12,
    "HEAD_STALLED": 13,
    "HEAD_RUNAWAY": 14,
    "TIP_BEYOND_CAP": 15,
    "WITHDRAWAL_BLOCKED": 16,
    "WITHDRAWAL_UNSEEN": 17,
    "DRIVE_OVERFORCE": 18,
    "HEAD_SENSORS_DISAGREE": 19,
    "VACUUM_LOST": 24,
    "CANISTER_FULL": 25,
    "LINE_CLOGGED": 26,
    "LINE_LEAKING": 27,
    "CARINA_MISSED": 28,
    "CONTACT_STUCK_CLOSED": 29,
    "CONTACT_STUCK_OPEN": 30,
    "VALVE_STUCK_OPEN": 31,
    "VALVE_STUCK_CLOSED": 32,
    "PUMP_RUNAWAY": 33,
    "CATHETER_JAMMED": 34,
    "SPO2_LOW": 36,
    "HEART_RATE_LOW": 37,
    "AIRWAY_PRESSURE_UNSAFE": 38,
    "LUNG_VOLUME_LOST": 39,
    "CIRCUIT_DISCONNECTED": 40,
    "MONITOR_LINK_LOST": 41,
    "CARRIAGE_READING_INVALID": 51,
}
"""Recordings hold these numbers: a new trip is added, an old one never renumbered."""


def mask(chosen: Collection[int]) -> int:
    return sum(1 << code for code in chosen)


def test_numbers_in_recordings_keep_their_meaning() -> None:
    assert {code.name: int(code) for code in Trip} == NUMBERS


def test_every_trip_stops_the_cycle_and_says_why_in_words() -> None:
    assert set(KINDS) == set(Trip)
    sentences = [kind.sentence for kind in KINDS.values()]
    assert len(set(sentences)) == len(sentences)
    for kind in KINDS.values():
        assert kind.reaction >= Reaction.WITHDRAW
        assert kind.priority in ("high", "medium")
        assert kind.sentence[0].islower()
        assert not kind.sentence.endswith(".")


def test_reactions_are_ordered_mildest_first() -> None:
    assert sorted(Reaction) == [
        Reaction.PASS,
        Reaction.CAP,
        Reaction.HOLD,
        Reaction.WITHDRAW,
        Reaction.TORQUE_OFF,
    ]


@given(chosen=trips)
def test_the_strongest_reaction_of_several_trips_counts(chosen: set[Trip]) -> None:
    expected = max((KINDS[code].reaction for code in chosen), default=Reaction.PASS)
    assert trip.reaction(mask(chosen)) == expected


@given(chosen=trips)
def test_vacuum_is_cut_if_any_trip_asks_for_it(chosen: set[Trip]) -> None:
    assert trip.cuts_vacuum(mask(chosen)) == any(KINDS[code].vacuum_cut for code in chosen)


@given(chosen=trips)
def test_names_reads_a_mask_back(chosen: set[Trip]) -> None:
    assert trip.names(mask(chosen)) == sorted(chosen)


def test_every_trip_has_a_bit_of_a_mask_and_a_bit_that_is_no_trips_does_nothing() -> None:
    assert max(Trip) < trip.WORD
    nobodys = mask(set(range(trip.WORD)) - set(Trip))
    assert trip.reaction(nobodys) == Reaction.PASS
    assert not trip.cuts_vacuum(nobodys)


TORQUE_OFF = {
    # The head does the opposite of what it is told, or more of it: it is not asked to withdraw.
    "HEAD_OVERSPEED",
    "HEAD_RUNAWAY",
    "DRIVE_OVERFORCE",
    # It has been pulled and did not come, or nobody knows whether it did: no more force.
    "WITHDRAWAL_TIME",
    "WITHDRAWAL_BLOCKED",
    "WITHDRAWAL_UNSEEN",
}
"""All others withdraw."""
VACUUM_KEPT = {
    # Nothing is wrong with the suction; it stays as proposed on the way out.
    "CONTACT_READING_INVALID",
    # What hangs at the tip would be left in the airway.
    "LINE_CLOGGED",
}
"""All others cut it."""
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
"""All others are of high priority."""


@pytest.mark.parametrize("code", Trip, ids=lambda code: code.name)
def test_every_trip_comes_out_first_without_suction_unless_the_fault_demands_otherwise(
    code: Trip,
) -> None:
    moves = code.name not in TORQUE_OFF
    assert trip.reaction(1 << code) == (Reaction.WITHDRAW if moves else Reaction.TORQUE_OFF)
    assert trip.cuts_vacuum(1 << code) == (code.name not in VACUUM_KEPT)
    assert KINDS[code].priority == ("medium" if code.name in MEDIUM else "high")


def test_nothing_wrong_is_nothing_done() -> None:
    assert trip.reaction(0) == Reaction.PASS
    assert not trip.cuts_vacuum(0)
    assert trip.names(0) == []


def test_torque_off_beats_withdrawal_and_a_cut_beats_a_vacuum_that_is_kept() -> None:
    both = mask({Trip.LINE_CLOGGED, Trip.HEAD_RUNAWAY, Trip.SPO2_LOW})
    assert trip.reaction(both) == Reaction.TORQUE_OFF
    assert trip.cuts_vacuum(both)
    kept = mask({Trip.LINE_CLOGGED, Trip.CONTACT_READING_INVALID})
    assert trip.reaction(kept) == Reaction.WITHDRAW
    assert not trip.cuts_vacuum(kept)


def test_numbers_of_reactions_in_recordings_keep_their_meaning() -> None:
    assert {reaction.name: int(reaction) for reaction in Reaction} == {
        "PASS": 0,
        "CAP": 1,
        "HOLD": 2,
        "WITHDRAW": 3,
        "TORQUE_OFF": 4,
    }


def test_a_mask_has_as_many_bits_as_a_double_holds_exactly() -> None:
    every_bit = mask(range(trip.WORD))
    assert int(float(every_bit)) == every_bit
    assert int(float(2 * every_bit + 1)) != 2 * every_bit + 1
    assert trip.REACTIONS.size == trip.CUTS.size == trip.WORD
