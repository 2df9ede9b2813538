"""A failure in real time is the program's, or the computer's; which of the two is told apart."""

from collections import Counter
from collections.abc import Sequence

import pytest

from tests.stage.judge import NOT_JUDGED_MOST, REPEATS, Premise, RealTimeJudge, Standstill

pytest_plugins = ("pytester",)
STILL, QUIET = Standstill(0.03, 0.03), Standstill(0.015, 0.4)
HEAD = "import pytest\n"


def outcome(
    pytester: pytest.Pytester, looks: Sequence[Standstill], source: str
) -> tuple[Counter[str], RealTimeJudge, int]:
    """What came of a module's tests. looks: what is seen of the computer; the last one for ever."""
    left = list(looks)
    pytester.makepyfile(HEAD + source)
    pytester.makeini("[pytest]\nmarkers = real_time\n")
    judge = RealTimeJudge(lambda _: left.pop(0) if len(left) > 1 else left[0])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # each run would import them anew
        run = pytester.inline_run("-p", "no:cacheprovider", plugins=[judge])
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
    counts, judge, status = outcome(pytester, [QUIET], FAILS)
    assert counts == Counter(failed=1)
    assert (judge.repeated, judge.not_judged, status) == ([], [], 1)


def test_one_on_a_computer_that_stood_still_is_repeated_with_everything_made_anew(
    pytester: pytest.Pytester,
) -> None:
    counts, judge, status = outcome(pytester, [STILL], PASSES_AT_THE_SECOND_TRY)
    assert counts == Counter(passed=2)
    assert (len(judge.repeated), judge.not_judged, status) == (1, [], 0)
    assert "test_it: a real-time process stood still for 30 ms, 20 ms are" in judge.repeated[0]


def test_a_failure_after_a_repeat_on_a_quiet_computer_is_a_failure(
    pytester: pytest.Pytester,
) -> None:
    counts, judge, status = outcome(pytester, (STILL, QUIET), FAILS)
    assert counts == Counter(failed=1)
    assert (len(judge.repeated), judge.not_judged, status) == (1, [], 1)


def test_a_machine_that_cannot_be_begun_is_judged_like_a_failure(
    pytester: pytest.Pytester,
) -> None:
    source = PASSES_AT_THE_SECOND_TRY.replace(
        "return len(made)", "assert len(made) == 2\n    return 2"
    )
    assert outcome(pytester, [STILL], source)[0] == Counter(passed=2)
    assert outcome(pytester, [QUIET], source)[2] == 1


def test_what_was_never_judged_is_told_with_the_standstill_and_too_much_of_it_fails_the_run(
    pytester: pytest.Pytester,
) -> None:
    counts, judge, status = outcome(pytester, [STILL], FAILS)
    assert counts == Counter(skipped=1)
    assert (len(judge.repeated), len(judge.not_judged), status) == (REPEATS, 1, 0)
    many = "".join(FAILS.replace("test_it", f"test_{n}") for n in range(NOT_JUDGED_MOST + 1))
    counts, judge, status = outcome(pytester, [STILL], many)
    assert counts == Counter(skipped=NOT_JUDGED_MOST + 1)
    assert status == 1


def test_a_test_that_is_not_in_real_time_is_never_excused(pytester: pytest.Pytester) -> None:
    source = FAILS.replace("@pytest.mark.real_time\n", "")
    assert outcome(pytester, [STILL], source)[0] == Counter(failed=1)


def test_each_test_states_its_own_premise(pytester: pytest.Pytester) -> None:
    source = FAILS.replace("real_time", "real_time(machine_s=0.05)")
    assert outcome(pytester, [STILL], source)[0] == Counter(failed=1)
    strict = FAILS.replace("real_time", "real_time(others_s=0.02)")
    assert outcome(pytester, [STILL], strict)[0] == Counter(skipped=1)
    assert Premise().breach(Standstill(0.02, 0.5)) == ""
    assert Premise().breach(Standstill(0.0, 0.6)).startswith("an ordinary process stood still for")
    assert Premise().breach(Standstill(0.004, 0.01, late_ticks=3)) == ""
    assert Premise().breach(Standstill(0.004, 0.01, late_ticks=4)) == (
        "a real-time process was late for 4 ticks in a row, 3 are allowed"
    )
