"""Runs the tests of a module against each of its mutants.

Each mutant gets a process of its own, forked from one that has already imported what is slow
(numba, numpy, hypothesis, pytest). There the import of the module gives the mutant; no file is
changed. The core runs as plain Python.
"""

import ast
import contextlib
import importlib.util
import itertools
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from tools.mutation.operator import mutants

ROOT = Path(__file__).resolve().parents[2]
SLOW_IMPORTS = ("numba", "numpy", "scipy.signal", "scipy.optimize", "hypothesis", "pytest")
TIME_FACTOR = 5.0
TIME_ADDED_S = 10.0
"""A mutant may take so much longer than the sound module before it counts as noticed."""
POLL_S = 0.01

ENVIRONMENT = {
    "NUMBA_DISABLE_JIT": "1",
    "OPENSUCTION_HYPOTHESIS": "mutation",
    "OPENBLAS_NUM_THREADS": "1",
}


class Target(NamedTuple):
    """A module and the tests that must notice its mistakes."""

    module: str
    tests: tuple[str, ...]
    """Files, relative to the root; may be patterns."""
    function: str = ""
    """The only one of the module that is changed; all of it where it has no name."""

    def path(self) -> Path:
        """Its source."""
        return ROOT / "src" / Path(*self.module.split(".")).with_suffix(".py")

    def test_files(self) -> list[str]:
        """Its tests."""
        found = [str(path) for pattern in self.tests for path in sorted(ROOT.glob(pattern))]
        if not found:
            raise FileNotFoundError(f"no tests for {self.module}: {', '.join(self.tests)}")
        return list(dict.fromkeys(found))

    def lines(self) -> range:
        """Lines of its source that are changed. Raises ValueError for an unknown function."""
        source = self.path().read_text(encoding="utf-8")
        if not self.function:
            return range(1, len(source.splitlines()) + 1)
        for node in ast.parse(source).body:
            if isinstance(node, ast.FunctionDef) and node.name == self.function:
                return range(node.lineno, (node.end_lineno or node.lineno) + 1)
        raise ValueError(f"no function {self.function} in {self.module}")


class Survivor(NamedTuple):
    """A mistake that no test noticed."""

    line: int
    column: int
    change: str


class Result(NamedTuple):
    """Result of the mutants of a module."""

    module: str
    mutants: int
    killed: int
    timed_out: int
    """Of the killed: those that did not end in time."""
    survivors: tuple[Survivor, ...]
    seconds: float

    @property
    def score_percent(self) -> float:
        """Share of the mutants that a test noticed."""
        return 100.0 * self.killed / self.mutants if self.mutants else 100.0


class MutantFinder(MetaPathFinder, Loader):
    """Imports a changed tree in the place of one module."""

    def __init__(self, module: str, path: Path, tree: ast.Module) -> None:
        self.module = module
        self.path = path
        self.tree = tree

    def find_spec(
        self, fullname: str, _path: Sequence[str] | None, _target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """A spec for the one module, nothing for any other."""
        if fullname != self.module:
            return None
        return importlib.util.spec_from_file_location(fullname, self.path, loader=self)

    def exec_module(self, module: ModuleType) -> None:
        """Run the changed tree in the place of the source."""
        exec(compile(self.tree, str(self.path), "exec"), module.__dict__)  # noqa: S102


def _tested(target: Target, tree: ast.Module | None) -> int:
    """Run the tests in this process; 0 if they pass. Standard output and error are dropped."""
    import pytest

    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    if tree is not None:
        sys.meta_path.insert(0, MutantFinder(target.module, target.path(), tree))
    options = ["-x", "-q", "--tb=no", "--assert=plain", "-p", "no:cacheprovider", "-m", "not soak"]
    ended = set()
    for file in target.test_files():  # one by one: what the later ones import is seldom needed
        code = int(pytest.main([*options, file]))
        if code not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
            return code
        ended.add(code)
    return min(ended)


def _forked(target: Target, tree: ast.Module | None) -> int:
    """Identifier of a new process that runs the tests and exits with 0 if they pass."""
    child = os.fork()
    if child:
        return child
    code = 1
    with contextlib.suppress(BaseException):
        os.setsid()
        code = _tested(target, tree)
    os._exit(code)


class _Running(NamedTuple):
    mutant: Survivor
    deadline_s: float


def _reap(running: dict[int, _Running]) -> Iterator[tuple[Survivor, bool, bool]]:
    """Mutants whose tests have ended or taken too long: noticed, and whether by time."""
    for child, run in list(running.items()):
        ended, status = os.waitpid(child, os.WNOHANG)
        late = not ended and time.monotonic() > run.deadline_s
        if late:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
        if ended or late:
            del running[child]
            yield run.mutant, late or status != 0, late


def prepare() -> None:
    """Import what is slow, once; the core as plain Python from here on."""
    os.environ.update(ENVIRONMENT)
    os.chdir(ROOT)
    sys.path[:0] = [str(ROOT), str(ROOT / "src")]
    for name in SLOW_IMPORTS:
        importlib.import_module(name)


def sound_s(target: Target) -> float:
    """Time that the tests take on the module as it is, s.

    Raises RuntimeError where they do not pass.
    """
    begin_s = time.monotonic()
    _, status = os.waitpid(_forked(target, None), 0)
    if status != 0:
        raise RuntimeError(f"the tests of {target.module} fail on the module as it is")
    return time.monotonic() - begin_s


def run(target: Target, workers: int, tell: Callable[[str], None], every: int = 1) -> Result:
    """Every mutant of a module, or of a function, against the module's tests.

    workers: processes at a time. every: try only each so many-th mutant, a sample of the module.
    tell: takes a line for each survivor as it appears.
    """
    begin_s = time.monotonic()
    limit_s = TIME_FACTOR * workers * sound_s(target) + TIME_ADDED_S
    running: dict[int, _Running] = {}
    survivors: list[Survivor] = []
    counted = killed = timed_out = 0

    def settle(room: int) -> None:
        nonlocal killed, timed_out
        while len(running) > room:
            for mutant, noticed, late in _reap(running):
                killed += noticed
                timed_out += late
                if not noticed:
                    survivors.append(mutant)
                    tell(f"  survived {target.module}:{mutant.line}: {mutant.change}")
            time.sleep(POLL_S)

    lines = target.lines()
    found = mutants(target.path().read_text(encoding="utf-8"))
    within = (mutant for mutant in found if mutant.line in lines)
    try:
        for mutant in itertools.islice(within, 0, None, every):
            counted += 1
            settle(workers - 1)
            running[_forked(target, mutant.tree)] = _Running(
                Survivor(mutant.line, mutant.column, mutant.change), time.monotonic() + limit_s
            )
        settle(0)
    finally:  # interrupted: leave no process behind
        for child in running:
            os.kill(child, signal.SIGKILL)
    seconds = time.monotonic() - begin_s
    return Result(target.module, counted, killed, timed_out, tuple(sorted(survivors)), seconds)
