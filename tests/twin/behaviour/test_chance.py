import math

import pytest

from opensuction.kernel import random_stream
from opensuction.twin.behaviour import spontaneous_event


def test_events_come_as_often_as_the_rate_says_and_independently_of_one_another() -> None:
    """2,000 waiting times of an exponential: mean and deviation 1, within 4 standard errors."""
    coming = spontaneous_event.draw(random_stream.stream(1, 9))
    waits = []
    for _ in range(2000):
        waits.append(coming.left)
        coming = spontaneous_event.draw(coming.stream)
    mean = sum(waits) / 2000
    assert mean == pytest.approx(1.0, abs=4.0 / math.sqrt(2000))
    spread = math.sqrt(sum((wait - mean) ** 2 for wait in waits) / 2000)
    assert spread == pytest.approx(1.0, abs=0.13)


def test_a_rate_that_changes_wears_by_what_it_was() -> None:
    coming = spontaneous_event.draw(random_stream.stream(1, 9))
    half = spontaneous_event.wear(coming, 0.5 * coming.left, 1.0)
    assert not spontaneous_event.is_due(half)
    assert spontaneous_event.is_due(spontaneous_event.wear(half, 50.0 * coming.left, 0.0101))
    assert not spontaneous_event.is_due(spontaneous_event.wear(half, 0.0, 1.0e6))
