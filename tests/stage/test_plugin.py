"""A failure in real time is the program's, or the computer's; which of the two is told apart."""

from collections import Counter

import pytest

from tests.stage import __main__ as stages
from tests.stage.plugin import NOT_JUDGED_MOST, REPEATS, Premise, RealTimeJudge
from tests.stage.standstill import Standstill, StandstillWatch

pytest_plugins = ("pytester",)
STILL, QUIET = Standstill(0.03, 0.03), Standstill(0.015, 0.4)
HEAD = "import pytest\n"


class PlayedWatch(StandstillWatch):
    """A computer that stands still as a test wants it to; of the last look it says so for ever."""

    def __init__(self, *looks: Standstill) -> None:
        self._looks = list(looks)

    def longest(self, since_ns: int) -> Standstill:
        assert since_ns > 0
        return self._looks.pop(0) if len(self._looks) > 1 else self._looks[0]


def outcome(
    pytester: pytest.Pytester, watch: PlayedWatch, source: str
) -> tuple[Counter[str], RealTimeJudge, int]:
    """What came of a module's tests."""
    pytester.makepyfile(HEAD + source)
    pytester.makeini("[pytest]\nmarkers = real_time\n")
    judge = RealTimeJudge(watch)
    run = pytester.inline_run("-p", "no:cacheprovider", "-p", "no:xdist", plugins=[judge])
    passed, skipped, failed = run.listoutcomes()
    counts = Counter(passed=len(passed), skipped=len(skipped), failed=len(failed))
    return counts, judge, int(run.ret or 0)


FAILS = "@pytest.mark.real_time\ndef test_it():\n    assert False\n"
PASSES_AT_THE_SECOND_TRY = """
made = []
@pytest.fixture(scope="module")
def machine():
    made.append(1)
    return len(made)
@pytest.mark.real_time
def test_it(machine):
    assert machine == 2
@pytest.mark.real_time
def test_another(machine):
    assert machine == 2
"""


def test_a_failure_on_a_computer_that_kept_its_word_is_a_failure(
    pytester: pytest.Pytester,
) -> None:
    counts, judge, status = outcome(pytester, PlayedWatch(QUIET), FAILS)
    assert counts == Counter(failed=1)
    assert (judge.repeated, judge.not_judged, status) == ([], [], 1)


def test_one_on_a_computer_that_stood_still_is_repeated_with_everything_made_anew(
    pytester: pytest.Pytester,
) -> None:
    counts, judge, status = outcome(pytester, PlayedWatch(STILL), PASSES_AT_THE_SECOND_TRY)
    assert counts == Counter(passed=2)
    assert (len(judge.repeated), judge.not_judged, status) == (1, [], 0)
    assert "test_it: a real-time process stood still for 30 ms, 20 ms are" in judge.repeated[0]


def test_a_failure_after_a_repeat_on_a_quiet_computer_is_a_failure(
    pytester: pytest.Pytester,
) -> None:
    counts, judge, status = outcome(pytester, PlayedWatch(STILL, QUIET), FAILS)
    assert counts == Counter(failed=1)
    assert (len(judge.repeated), judge.not_judged, status) == (1, [], 1)


def test_a_machine_that_cannot_be_begun_is_judged_like_a_failure(
    pytester: pytest.Pytester,
) -> None:
    source = PASSES_AT_THE_SECOND_TRY.replace(
        "return len(made)", "assert len(made) == 2\n    return 2"
    )
    assert outcome(pytester, PlayedWatch(STILL), source)[0] == Counter(passed=2)
    assert outcome(pytester, PlayedWatch(QUIET), source)[2] == 1


def test_what_was_never_judged_is_told_with_the_standstill_and_too_much_of_it_fails_the_run(
    pytester: pytest.Pytester,
) -> None:
    counts, judge, status = outcome(pytester, PlayedWatch(STILL), FAILS)
    assert counts == Counter(skipped=1)
    assert (len(judge.repeated), len(judge.not_judged), status) == (REPEATS, 1, 0)
    many = "".join(FAILS.replace("test_it", f"test_{n}") for n in range(NOT_JUDGED_MOST + 1))
    counts, judge, status = outcome(pytester, PlayedWatch(STILL), many)
    assert counts == Counter(skipped=NOT_JUDGED_MOST + 1)
    assert status == 1


def test_a_test_that_is_not_in_real_time_is_never_excused(pytester: pytest.Pytester) -> None:
    source = FAILS.replace("@pytest.mark.real_time\n", "")
    assert outcome(pytester, PlayedWatch(STILL), source)[0] == Counter(failed=1)


def test_each_test_states_its_own_premise(pytester: pytest.Pytester) -> None:
    source = FAILS.replace("real_time", "real_time(machine_s=0.05)")
    assert outcome(pytester, PlayedWatch(STILL), source)[0] == Counter(failed=1)
    strict = FAILS.replace("real_time", "real_time(others_s=0.02)")
    assert outcome(pytester, PlayedWatch(STILL), strict)[0] == Counter(skipped=1)
    assert Premise().breach(Standstill(0.02, 0.5)) == ""
    assert Premise().breach(Standstill(0.0, 0.6)).startswith("an ordinary process stood still for")


@pytest.mark.parametrize(
    ("statuses", "expected"), [([0, 0], 0), ([5, 0], 0), ([5, 5], 5), ([0, 1], 1), ([1, 0], 1)]
)
def test_a_stage_without_a_test_fails_nothing(statuses: list[int], expected: int) -> None:
    assert stages._status(statuses) == expected


def test_both_stages_end_in_one_line() -> None:
    counts = Counter(passed=8976, failed=2, error=0, skipped=1)
    line = stages._summary(counts, 1575.58)
    assert line.strip("= ") == "2 failed, 8976 passed, 1 skipped in 1575.58s (0:26:16)"
    assert "no tests ran in" in stages._summary(Counter(), 1.0)
