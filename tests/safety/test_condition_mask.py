from hypothesis import given
from hypothesis import strategies as st

from opensuction.kernel.codegen.row import columns
from opensuction.safety import condition_mask
from opensuction.safety.alarm import alarm_clock
from opensuction.safety.alarm.alarm_state import Signals
from opensuction.safety.condition import Condition, row_of
from opensuction.safety.condition_mask import EVERY_BIT, TRIPS, WORD, decode, decode_trips, encode
from opensuction.safety.handling import Priority, Reaction

some_conditions = st.sets(st.sampled_from(Condition))


@given(chosen=some_conditions)
def test_the_strongest_reaction_of_several_trips_counts(chosen: set[Condition]) -> None:
    expected = max((code.row.handling.reaction for code in chosen), default=Reaction.PASS)
    assert condition_mask.strongest_reaction(encode(chosen)) == expected


@given(chosen=some_conditions)
def test_vacuum_is_cut_if_any_trip_asks_for_it(chosen: set[Condition]) -> None:
    expected = any(code.row.handling.cuts_vacuum for code in chosen)
    assert condition_mask.cuts_vacuum(encode(chosen)) == expected


@given(chosen=some_conditions)
def test_a_mask_is_read_back(chosen: set[Condition]) -> None:
    assert decode(encode(chosen)) == sorted(chosen)
    trips = {code for code in chosen if code.row.handling.reaction != Reaction.PASS}
    assert decode_trips(encode(chosen)) == sorted(trips)
    assert encode([*chosen, *chosen]) == encode(chosen)


def test_nothing_wrong_is_nothing_done() -> None:
    assert condition_mask.strongest_reaction(0) == Reaction.PASS
    assert not condition_mask.cuts_vacuum(0)
    assert decode(0) == []
    assert decode_trips(0) == []


def test_torque_off_beats_withdrawal_and_a_cut_beats_a_vacuum_that_is_kept() -> None:
    both = encode({Condition.LINE_CLOGGED, Condition.HEAD_RUNAWAY, Condition.SPO2_LOW})
    assert condition_mask.strongest_reaction(both) == Reaction.TORQUE_OFF
    assert condition_mask.cuts_vacuum(both)
    kept = encode({Condition.LINE_CLOGGED, Condition.CONTACT_READING_INVALID})
    assert condition_mask.strongest_reaction(kept) == Reaction.WITHDRAW
    assert not condition_mask.cuts_vacuum(kept)


def test_a_bit_that_is_no_trips_does_nothing() -> None:
    assert condition_mask.strongest_reaction(EVERY_BIT & ~TRIPS) == Reaction.PASS
    assert not condition_mask.cuts_vacuum(EVERY_BIT & ~TRIPS)
    assert decode_trips(EVERY_BIT & ~TRIPS) == []


def test_a_mask_has_as_many_bits_as_a_double_holds_exactly() -> None:
    # A recording holds every number as a double.
    assert decode(EVERY_BIT) == list(range(WORD))
    assert int(float(EVERY_BIT)) == EVERY_BIT
    assert int(float(2 * EVERY_BIT + 1)) != 2 * EVERY_BIT + 1
    assert max(Condition) < WORD
    assert {"present", "latched", "acknowledged"} <= set(columns(Signals))


def test_every_bit_has_one_priority_and_every_bit_is_a_conditions() -> None:
    high, medium, low = condition_mask.HIGHS, condition_mask.MEDIUMS, condition_mask.LOWS
    assert high + medium + low == EVERY_BIT == high | medium | low
    assert encode(Condition) == EVERY_BIT  # the mask is full: a new one needs a second word


def test_a_number_that_no_condition_has_is_high_and_latching() -> None:
    handling = row_of(WORD).handling
    assert (handling.priority, handling.latching, handling.planned) == (Priority.HIGH, True, False)


def test_compiled_code_reads_the_rows_of_every_bit() -> None:
    ranks = {
        Priority.HIGH: condition_mask.HIGHS,
        Priority.MEDIUM: condition_mask.MEDIUMS,
        Priority.LOW: condition_mask.LOWS,
    }
    for bit in range(WORD):
        handling = row_of(bit).handling
        assert (bit in alarm_clock.DELAYED) == (handling.delay_s > 0.0)
        assert (bit in alarm_clock.RISING) == (handling.escalates_s > 0.0)
        assert (condition_mask.LATCHING >> bit & 1) == handling.latching
        assert (condition_mask.PLANNED >> bit & 1) == handling.planned
        assert ranks[handling.priority] >> bit & 1
    assert WORD not in (*Condition, *alarm_clock.DELAYED, *alarm_clock.RISING)
