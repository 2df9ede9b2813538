"""Signs of life: who is missed, who has ended, who died and was replaced."""

from pathlib import Path

from opensuction.ipc.liveness import Heartbeat, Process


def test_one_that_never_was_and_one_that_has_ended_are_not_missed(tmp_path: Path) -> None:
    mine = Heartbeat(tmp_path)
    assert not mine.is_expected(Process.RECORDER)
    assert mine.age_s(Process.RECORDER) == float("inf")
    mine.begin(Process.RECORDER)
    assert mine.is_expected(Process.RECORDER)
    assert 0.0 <= mine.age_s(Process.RECORDER) < 5.0
    mine.end(Process.RECORDER)
    assert not mine.is_expected(Process.RECORDER)
    assert mine.age_s(Process.RECORDER) == float("inf")


def test_only_a_place_that_was_never_given_up_counts_as_a_death(tmp_path: Path) -> None:
    mine, other = Heartbeat(tmp_path), Heartbeat(tmp_path)
    mine.begin(Process.RECORDER)
    mine.end(Process.RECORDER)
    mine.begin(Process.RECORDER)
    assert other.deaths(Process.RECORDER) == 0
    other.begin(Process.RECORDER)
    assert mine.deaths(Process.RECORDER) == 1
    assert mine.deaths(Process.SUPERVISOR) == 0


def test_one_that_is_started_is_starting_until_it_works(tmp_path: Path) -> None:
    mine, other = Heartbeat(tmp_path), Heartbeat(tmp_path)
    assert other.signs(Process.RECORDER).starting_s is None
    mine.start(Process.RECORDER)
    assert other.signs(Process.RECORDER).starting_s is not None
    mine.work(Process.RECORDER)  # without a sign nobody works
    assert other.signs(Process.RECORDER).starting_s is not None
    mine.begin(Process.RECORDER)
    assert other.signs(Process.RECORDER).starting_s is not None
    mine.work(Process.RECORDER)
    assert other.signs(Process.RECORDER).starting_s is None


def test_one_that_has_died_is_not_waited_for(tmp_path: Path) -> None:
    mine, other = Heartbeat(tmp_path), Heartbeat(tmp_path)
    mine.begin(Process.RECORDER)
    other.start(Process.RECORDER)
    assert other.signs(Process.RECORDER).starting_s is None
    mine.end(Process.RECORDER)
    other.start(Process.RECORDER)
    assert other.signs(Process.RECORDER).starting_s is not None
    mine.end(Process.RECORDER)
    assert other.signs(Process.RECORDER).starting_s is None
