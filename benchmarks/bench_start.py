"""Waiting times of a user: the first cycle after installation, later cycles, the first output."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Tell
from benchmarks.timing import best_s
from opensuction.kernel.compiled import cache_root

CYCLE = [sys.executable, "-m", "opensuction.cli.app", "cycle", "--json", "--pace", "0"]


def cycle(cache: Path, out: Path) -> None:
    """One whole ``opensuction cycle`` in a process of its own."""
    environment = {**os.environ, "OPENSUCTION_CACHE_DIR": str(cache)}
    command = [*CYCLE, "--force", "--out", str(out)]
    subprocess.run(command, env=environment, capture_output=True, check=True, timeout=600)


def first_output_s(cache: Path, out: Path) -> float:
    """Time until the command writes anything at all."""
    environment = {**os.environ, "OPENSUCTION_CACHE_DIR": str(cache)}
    command = [*CYCLE, "--force", "--out", str(out)]
    begin = time.perf_counter()
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as process:
        assert process.stdout is not None
        process.stdout.read(1)
        waited = time.perf_counter() - begin
        process.stdout.read()
    return waited


@pytest.fixture(scope="module")
def cache(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of compiled code, empty for the first test of this file and warm for the others.

    The user's own where nothing is timed: an empty one costs a minute.
    """
    if request.config.getoption("benchmark_disable"):
        return cache_root()
    return tmp_path_factory.mktemp("compiled")


def test_first_cycle_ever(
    benchmark: BenchmarkFixture, tell: Tell, cache: Path, tmp_path: Path
) -> None:
    waited: list[float] = []
    whole_s = best_s(
        benchmark, lambda: waited.append(first_output_s(cache, tmp_path)), rounds=1, warm=False
    )
    tell(f"first cycle ever: {whole_s:.1f} s, first output after {waited[0] / whole_s:.0%} of it")


def test_next_cycle(benchmark: BenchmarkFixture, tell: Tell, cache: Path, tmp_path: Path) -> None:
    whole_s = best_s(benchmark, lambda: cycle(cache, tmp_path), rounds=3)
    tell(f"a later cycle: {whole_s:.2f} s for the whole command")


def test_first_output(benchmark: BenchmarkFixture, tell: Tell, cache: Path, tmp_path: Path) -> None:
    waited: list[float] = []
    whole_s = best_s(benchmark, lambda: waited.append(first_output_s(cache, tmp_path)), rounds=3)
    tell(f"first output after {min(waited):.2f} s, {min(waited) / whole_s:.0%} of the command")
