"""Both stages of a run come to one end."""

from collections import Counter

import pytest

from tests.stage import summary


@pytest.mark.parametrize(
    ("statuses", "expected"), [([0, 0], 0), ([5, 0], 0), ([5, 5], 5), ([0, 1], 1), ([1, 0], 1)]
)
def test_a_stage_without_a_test_fails_nothing(statuses: list[int], expected: int) -> None:
    assert summary.status(statuses) == expected


def test_both_stages_end_in_one_line() -> None:
    counts = Counter(passed=8976, failed=2, error=0, skipped=1)
    line = summary.line(counts, 1575.58)
    assert line.strip("= ") == "2 failed, 8976 passed, 1 skipped in 1575.58s (0:26:16)"
    assert "no tests ran in" in summary.line(Counter(), 1.0)
