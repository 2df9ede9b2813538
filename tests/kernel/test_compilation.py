"""What is compiled is told, root by root; what is compiled in one is counted."""

from typing import Any

import numba
import pytest
from numba import config

from opensuction.kernel import compilation
from opensuction.kernel.compilation import Compilation, Stage

pytestmark = pytest.mark.skipif(
    bool(getattr(config, "DISABLE_JIT")),  # noqa: B009 - numba sets it on import
    reason="nothing is compiled",
)


@numba.njit
def inner(x: Any) -> Any:
    return 2.0 * x


@numba.njit
def outer(x: Any) -> Any:
    return inner(x) + inner(x + 1)


@numba.njit
def broken(x: Any) -> Any:
    return x.nothing


@pytest.fixture
def heard() -> list[Compilation]:
    news: list[Compilation] = []
    compilation.listen(news.append)
    return news


def test_a_root_is_told_from_beginning_to_end(heard: list[Compilation]) -> None:
    assert outer(1) == 6.0
    compilation.listen(None)
    assert outer(2) == 10.0  # compiled already
    assert {one.root for one in heard} == {f"{__name__}.outer"}
    assert [one.stage for one in heard] == [
        Stage.BEGUN,
        *[Stage.TRANSLATED] * (len(heard) - 2),
        Stage.FINISHED,
    ]
    counts = [one.functions for one in heard]
    assert counts == list(range(len(heard)))
    assert counts[-1] == 2  # the inner one, and the root itself


def test_nobody_hears_of_what_comes_later(heard: list[Compilation]) -> None:
    compilation.listen(None)
    assert outer(1.5) == 8.0
    assert heard == []


def test_what_is_given_up_is_finished(heard: list[Compilation]) -> None:
    with pytest.raises(numba.TypingError):
        broken(1.0)
    compilation.listen(None)
    stages = [one.stage for one in heard]
    assert (stages[0], stages[-1]) == (Stage.BEGUN, Stage.FINISHED)
