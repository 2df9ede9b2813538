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


@pytest.mark.parametrize(
    "code", [Trip.HEAD_OVERSPEED, Trip.HEAD_RUNAWAY, Trip.DRIVE_OVERFORCE, Trip.WITHDRAWAL_BLOCKED]
)
def test_a_head_that_cannot_be_steered_or_is_held_fast_is_not_driven(code: Trip) -> None:
    assert KINDS[code].reaction == Reaction.TORQUE_OFF
