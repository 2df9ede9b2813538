import numpy as np
import pytest

from opensuction.identification import record


def test_blocks_are_the_whole_recording_in_order() -> None:
    for folds in (record.cut_evenly(403), record.cut(np.sin(np.linspace(0.0, 9.0, 403)))):
        assert folds.edges[0] == 0
        assert folds.edges[-1] == 403
        assert (np.diff(folds.edges) > 0).all()
        assert folds.parts.size == folds.blocks == len(folds.cuts)


def test_blocks_end_at_reversals_where_there_are_many() -> None:
    stroke = np.linspace(0.0, 1.0, 30, endpoint=False)
    folds = record.cut(np.tile(np.append(stroke, 1.0 - stroke), 8))
    assert folds.blocks == 16
    assert (folds.edges[1:-1] % 30 == 0).all()
    assert folds.reversals == (7, 8)
    many = record.cut(np.tile(np.append(stroke, 1.0 - stroke), 60))
    assert many.blocks == record.BLOCKS
    assert (many.edges[1:-1] % 30 == 0).all()


def test_few_strokes_are_cut_into_pieces() -> None:
    folds = record.cut(1.0 - np.abs(np.linspace(-1.0, 1.0, 401)))
    assert folds.blocks == record.BLOCKS


def test_parts_differ_in_speed_where_the_recording_does() -> None:
    stroke = np.append(np.linspace(0.0, 1.0, 50), np.linspace(1.0, 0.0, 50)[1:-1])
    input_ = np.append(np.tile(stroke, 3), np.tile(stroke[::4], 12))
    folds = record.cut(input_)
    assert folds.by_speed
    fast = [bool(cut.start >= 290) for cut in folds.cuts]
    assert folds.parts.astype(bool).tolist() == fast
    even = record.cut(np.tile(stroke, 6))
    assert not even.by_speed
    assert even.parts.tolist() == sorted(even.parts)


def test_a_recording_with_time_is_judged_by_it() -> None:
    stroke = np.append(np.linspace(0.0, 1.0, 50), np.linspace(1.0, 0.0, 50)[1:-1])
    input_ = np.tile(stroke, 8)
    steps = np.where(np.arange(input_.size) < input_.size // 2, 1.0, 4.0)
    assert record.cut(input_, np.cumsum(steps)).by_speed


RANDOM = np.random.default_rng(3)
NOISE = RANDOM.normal(0.0, 0.05, 20)


def test_the_simplest_that_is_not_surely_worse_is_chosen() -> None:
    best = 1.0 + np.abs(NOISE)
    assert record.choose_simplest([5.0 * best, best + 0.02 * NOISE[::-1], best]) == 1
    assert record.choose_simplest([best, 0.5 * best]) == 1


def test_a_single_block_does_not_decide_alone() -> None:
    """One block that nobody predicts makes the squares all alike; the others still tell."""
    rich, poor = 0.01 + 0.01 * np.abs(NOISE), np.ones(20)
    rich[0], poor[0] = 300.0, 280.0
    assert record.choose_simplest([poor, rich]) == 1


def test_a_model_that_fails_in_a_block_is_not_saved_by_the_others() -> None:
    steady, wild = 1.0 + 0.1 * np.abs(NOISE), 0.8 + 0.1 * np.abs(NOISE)
    wild[:7] = 50.0
    assert record.choose_simplest([wild, steady]) == 1


def test_how_much_of_the_range_was_passed_either_way() -> None:
    """A stroke and back over three quarters of it, and an advance over the rest."""
    there = np.linspace(0.0, 75.0, 300)
    path = np.concatenate([there, there[::-1], np.linspace(0.0, 100.0, 400)])
    assert record.cut(path).both_ways == pytest.approx(0.8)  # sixteen of twenty places
    assert record.cut(np.concatenate([path, path[::-1]])).both_ways == 1.0
