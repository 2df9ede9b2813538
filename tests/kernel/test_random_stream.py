import math

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.kernel.compiled import compiled
from opensuction.kernel.random_stream import (
    RandomStream,
    normal_pair,
    stream,
    threefry,
    uniform_pair,
)
from tests.conformance.plain import run_plain

ONES = 0xFFFFFFFF


@compiled
def draw(source: RandomStream, normal: bool, pairs: int) -> NDArray[np.float64]:
    """Pairs of numbers drawn one after another, shape (2 * pairs,)."""
    numbers = np.empty(2 * pairs)
    for k in range(pairs):
        if normal:
            numbers[2 * k], numbers[2 * k + 1], source = normal_pair(source)
        else:
            numbers[2 * k], numbers[2 * k + 1], source = uniform_pair(source)
    return numbers


@pytest.mark.parametrize(
    ("key", "block", "words"),
    [
        ((0, 0), (0, 0), (0x6B200159, 0x99BA4EFE)),
        ((ONES, ONES), (ONES, ONES), (0x1CB996FC, 0xBB002BE7)),
        ((0x13198A2E, 0x03707344), (0x243F6A88, 0x85A308D3), (0xC4923A9C, 0x483DF7A0)),
    ],
)
def test_known_answers_of_the_authors(
    key: tuple[int, int], block: tuple[int, int], words: tuple[int, int]
) -> None:
    # Random123, kat_vectors, threefry2x32 with 20 rounds.
    assert threefry(key[0], key[1], block[0], block[1]) == words


def test_uniform_numbers_fill_the_open_unit_interval_evenly() -> None:
    numbers = draw(stream(7, 1), False, 50_000)
    assert 0.0 < numbers.min() < 1e-3
    assert 0.999 < numbers.max() < 1.0
    counts, _ = np.histogram(numbers, bins=20, range=(0.0, 1.0))
    # Chi-square with 19 degrees of freedom exceeds 43.8 once in a thousand seeds.
    assert float(((counts - 5000.0) ** 2 / 5000.0).sum()) < 43.8


def test_normal_numbers_have_the_moments_of_the_normal_distribution() -> None:
    numbers = draw(stream(7, 2), True, 50_000)
    # Four standard errors of each moment of 100,000 numbers.
    error = 4.0 / math.sqrt(numbers.size)
    assert numbers.mean() == pytest.approx(0.0, abs=error)
    assert numbers.var() == pytest.approx(1.0, abs=math.sqrt(2.0) * error)
    assert (numbers**3).mean() == pytest.approx(0.0, abs=math.sqrt(15.0) * error)
    assert (numbers**4).mean() == pytest.approx(3.0, abs=math.sqrt(96.0) * error)


def test_neighbouring_numbers_and_the_two_of_a_pair_are_independent() -> None:
    numbers = draw(stream(3, 1), True, 50_000)
    for lag in (1, 2):
        correlation = float(np.corrcoef(numbers[:-lag], numbers[lag:])[0, 1])
        assert correlation == pytest.approx(0.0, abs=4.0 / math.sqrt(numbers.size))


def test_a_stream_repeats_itself_exactly() -> None:
    assert np.array_equal(draw(stream(5, 1), True, 100), draw(stream(5, 1), True, 100))


@pytest.mark.parametrize("other", [(5, 2), (6, 1)])
def test_another_purpose_or_seed_is_another_stream(other: tuple[int, int]) -> None:
    one, two = draw(stream(5, 1), False, 10_000), draw(stream(*other), False, 10_000)
    assert not np.isin(one, two).sum() > 2  # by chance 0.1 of 2**32 values coincide
    assert float(np.corrcoef(one, two)[0, 1]) == pytest.approx(0.0, abs=4.0 / math.sqrt(one.size))


def test_a_stream_goes_on_after_four_thousand_million_blocks() -> None:
    last = RandomStream(key_0=1, key_1=1, counter=ONES)
    *_, advanced = uniform_pair(last)
    assert advanced.counter == ONES + 1
    assert uniform_pair(advanced)[:2] != uniform_pair(RandomStream(1, 1, 0))[:2]


def results() -> list[float]:
    """Numbers whose every bit should be the same compiled and as plain Python."""
    source = stream(2026, 3)
    return [
        *(float(word) for word in threefry(ONES, 17, 4, ONES)),
        *draw(source, False, 50),
        *draw(RandomStream(key_0=1, key_1=2, counter=ONES), False, 2),
        *draw(source, True, 50),
    ]


def test_compiled_equals_plain_python() -> None:
    plain = run_plain("tests.kernel.test_random_stream", "results")
    assert isinstance(plain, list)
    compiled_numbers = results()
    # Words and uniform numbers to the bit; normal ones pass through library functions.
    assert compiled_numbers[:106] == plain[:106]
    assert compiled_numbers == pytest.approx(plain, rel=1e-12, abs=1e-12)
