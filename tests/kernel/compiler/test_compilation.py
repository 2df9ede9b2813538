"""Notices of compilation, root by root, with the count of functions compiled in each."""

from typing import Any

import numba
import pytest
from numba import config

from opensuction.kernel.compiled import compiled
from opensuction.kernel.compiler import compilation
from opensuction.kernel.compiler.compilation import Compilation, Stage

pytestmark = pytest.mark.skipif(
    bool(getattr(config, "DISABLE_JIT")),  # noqa: B009 - numba sets it on import
    reason="nothing is compiled",
)


@pytest.fixture
def heard() -> list[Compilation]:
    news: list[Compilation] = []
    compilation.listen(news.append)
    return news


def test_a_root_is_told_from_beginning_to_end(heard: list[Compilation]) -> None:
    @compiled
    def inner(x: Any) -> Any:
        return 2.0 * x

    @compiled
    def outer(x: Any) -> Any:
        return inner(x) + inner(x + 1)

    assert outer(1) == 6.0
    compilation.listen(None)
    assert outer(2) == 10.0  # compiled already
    assert {one.root.rsplit(".", 1)[-1] for one in heard} == {"outer"}
    assert [(one.stage, one.functions) for one in heard] == [
        (Stage.BEGUN, 0),
        (Stage.TRANSLATED, 1),  # the inner one
        (Stage.TRANSLATED, 2),
        (Stage.OPTIMISING, 2),
        (Stage.FINISHED, 2),
    ]


def test_a_name_is_told_without_the_package(heard: list[Compilation]) -> None:
    def step(x: float) -> float:
        return x

    step.__module__ = "opensuction.control.servo"
    with compilation.report(step):
        pass
    compilation.listen(None)
    name = f"control.servo.{step.__qualname__}"
    assert heard == [Compilation(name, Stage.BEGUN, 0), Compilation(name, Stage.FINISHED, 0)]


def test_nobody_hears_of_what_comes_later(heard: list[Compilation]) -> None:
    @compiled
    def late(x: float) -> float:
        return x

    compilation.listen(None)
    assert late(1.5) == 1.5
    assert heard == []


def test_what_is_given_up_is_finished(heard: list[Compilation]) -> None:
    @compiled
    def broken(x: Any) -> Any:
        return x.nothing

    with pytest.raises(numba.TypingError):
        broken(1.0)
    compilation.listen(None)
    stages = [one.stage for one in heard]
    assert stages == [Stage.BEGUN, Stage.FINISHED]
