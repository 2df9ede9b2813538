"""A tiny core, edited between runs: every edit takes effect, and nothing is compiled twice."""

import json
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from opensuction.kernel import compiled as module
from opensuction.kernel.compiled import CACHE_FOLDER, PACKAGE, compiled, prune

KERNEL = ("__init__.py", "compiled.py", "private_file.py", "record.py")
"""What the tiny core has of the kernel, beside the whole of its compiler and `generated`."""

SOURCES = {
    "safety/__init__.py": "",
    "safety/record.py": """
from typing import NamedTuple

class Cap(NamedTuple):
    depth_mm: float
    speed_mm_per_s: float
""",
    "safety/table.py": "import numpy as np\nNEXT_PHASE = np.array([4, 5, 6])\n",
    "safety/limit.py": """
from opensuction.kernel.compiled import compiled

MARGIN_MM = 5.0

@compiled
def limit_mm(depth_mm: float) -> float:
    return depth_mm + MARGIN_MM
""",
    "controller/__init__.py": "",
    "controller/cycle.py": """
import numpy as np
from numpy.typing import NDArray

from opensuction.kernel.compiled import compiled
from opensuction.safety.limit import limit_mm
from opensuction.safety.record import Cap
from opensuction.safety.table import NEXT_PHASE

@compiled
def cycle(cap: Cap, phase: int) -> tuple[float, int]:
    return limit_mm(cap.depth_mm), NEXT_PHASE[phase]

@compiled
def check(cap: Cap) -> float:
    if cap.speed_mm_per_s < 0.0:
        raise ValueError(cap.speed_mm_per_s, "is negative")
    return cap.speed_mm_per_s

@compiled
def plan(cap: Cap) -> float:
    return cycle(cap, 1)[0] + limit_mm(check(cap))

@compiled
def deepen(cap: Cap) -> NDArray[np.float64]:
    return np.full(2, limit_mm(cap.depth_mm))

@compiled
def plan_deeper(cap: Cap) -> float:
    return deepen(cap)[0]

@compiled
def plan_again(cap: Cap) -> float:
    return plan(cap)
""",
    "controller/scale.py": """
from opensuction.kernel.compiled import compiled
from opensuction.kernel.codegen.row import define

scale_by_2 = define(["def scale(x):", "    return 2.0 * x"], "scale")
scale_by_3 = define(["def scale(x):", "    return 3.0 * x"], "scale")

@compiled
def double(x: float) -> float:
    return scale_by_2(x)

@compiled
def add_both(x: float) -> float:
    return double(x) + scale_by_3(x)
""",
}

PROGRAM = """
import json
from opensuction.controller.cycle import Cap, cycle, deepen, plan, plan_again, plan_deeper
from opensuction.controller.scale import add_both, double
from opensuction.kernel.compiler import compilation
from opensuction.safety.limit import limit_mm

def refusal(function, *args):
    try:
        function(*args)
    except ValueError as refused:
        return refused.args[0]

news = []
compilation.listen(news.append)
cap = Cap(depth_mm=120.0, speed_mm_per_s=9.0)
value = CALL
last = news[-1] if news else compilation.Compilation("", compilation.Stage.FINISHED, 0)
print(json.dumps([float(value), last.root, last.functions]))
"""

RUNNER = """
import json, os, sys
import numba
numba.njit(lambda x: x)(1.0)  # numba makes itself ready
for line in sys.stdin:
    asked = json.loads(line)
    child = os.fork()
    if child == 0:
        os.environ["OPENSUCTION_CACHE_DIR"] = asked["cache"]
        os.chdir(asked["folder"])
        sys.path.insert(0, asked["folder"])
        for stream, name in ((1, "stdout"), (2, "stderr")):
            os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), stream)
        exec(asked["program"])
        sys.stdout.flush()
        os._exit(0)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
"""Runs programs one after the other, each in a process that has imported numba and nothing else.

It ends without taking all that numba holds to pieces, which takes as long as what is asked of it.
"""

CYCLE = "sum(cycle(cap, 1))"
"""Only ``cycle`` is called from outside: whatever else changes is for it a changed callee."""


Runner = subprocess.Popen[str]


class Answer(NamedTuple):
    """What the tiny core answers, and what had to be compiled for it."""

    value: float
    root: str = ""
    """That had to be compiled; the last one."""
    translated: int = 0
    """Functions that had to be translated for it."""


class TinyCore:
    """A copy of the real kernel with the tiny rooms above it, and a cache of its own."""

    def __init__(self, folder: Path, runner: Runner) -> None:
        self.runner = runner
        self.package = folder / "opensuction"
        self.cache = folder / "cache"
        kernel = self.package / "kernel"
        kernel.mkdir(parents=True)
        (self.package / "__init__.py").touch()
        for room in ("compiler", "codegen"):
            shutil.copytree(PACKAGE / "kernel" / room, kernel / room)
        for name in KERNEL:
            shutil.copy(PACKAGE / "kernel" / name, kernel / name)
        for name, source in SOURCES.items():
            path = self.package / name
            path.parent.mkdir(exist_ok=True)
            path.write_text(source)

    def edit(self, name: str, old: str, new: str) -> None:
        """Change one file, with its time of change put back: only its content may count."""
        path = self.package / name
        times, text = path.stat(), path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))

    def run(self, call: str = CYCLE) -> Answer:
        """Run a call of the core in a fresh process."""
        folder = self.package.parent
        asked = {
            "folder": str(folder),
            "cache": str(self.cache),
            "program": PROGRAM.replace("CALL", call),
        }
        stdin, stdout = self.runner.stdin, self.runner.stdout
        assert stdin is not None
        assert stdout is not None
        stdin.write(json.dumps(asked) + "\n")
        stdin.flush()
        assert stdout.readline() == "0\n", (folder / "stderr").read_text()
        return Answer(*json.loads((folder / "stdout").read_text()))

    def files(self) -> dict[str, int]:
        """Files of the cache and when each was written."""
        found = [path for path in self.cache.rglob("*") if path.is_file()]
        return {str(path): path.stat().st_mtime_ns for path in found}


@pytest.fixture(scope="module")
def runner() -> Iterator[Runner]:
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": "0",
        "PYTHONDONTWRITEBYTECODE": "1",  # Python's own cache trusts times of change
    }
    command = [sys.executable, "-c", RUNNER]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe, text=True) as process:
        yield process


@pytest.fixture
def core(tmp_path: Path, runner: Runner) -> TinyCore:
    return TinyCore(tmp_path, runner)


def test_an_edit_anywhere_in_the_core_takes_effect(core: TinyCore) -> None:
    assert core.run() == Answer(130.0, "controller.cycle.cycle", 2)
    core.edit("safety/limit.py", "MARGIN_MM = 5.0", "MARGIN_MM = 7.0")
    assert core.run().value == 132.0
    core.edit("safety/table.py", "[4, 5, 6]", "[4, 9, 6]")
    assert core.run().value == 136.0
    # The caller builds the record by keyword; stale machine code would take the speed, 9, for it.
    core.edit(
        "safety/record.py",
        "    depth_mm: float\n    speed_mm_per_s: float\n",
        "    speed_mm_per_s: float\n    depth_mm: float\n",
    )
    assert core.run() == Answer(136.0, "controller.cycle.cycle", 2)


def test_an_edit_of_a_callee_reaches_a_root_that_is_new(core: TinyCore) -> None:
    assert core.run().value == 130.0
    core.edit("safety/limit.py", "MARGIN_MM = 5.0", "MARGIN_MM = 7.0")
    assert core.run("plan(cap)") == Answer(143.0, "controller.cycle.plan", 4)


def test_an_unchanged_core_compiles_nothing(core: TinyCore) -> None:
    first = core.run()
    written = core.files()
    assert any(name.endswith(".nbc") for name in written)
    assert core.run() == Answer(first.value)
    assert core.files() == written


@pytest.mark.parametrize("suffix", ["nbc", "nbi", "translated"])
def test_a_damaged_file_of_the_cache_is_made_anew(core: TinyCore, suffix: str) -> None:
    core.run("limit_mm(1.0)")
    for file in core.cache.rglob(f"*.{suffix}"):
        file.write_bytes(file.read_bytes()[:-20])
    call = "limit_mm(1.0) + plan(cap)"
    assert core.run(call).value == 6.0 + 139.0
    assert core.run(call) == Answer(6.0 + 139.0)


def test_roots_that_hold_the_same_functions_live_in_one_process(core: TinyCore) -> None:
    # Each from the cache, the outer ones first: none may be bound to what another one holds.
    refused = "refusal(plan, cap._replace(speed_mm_per_s=-2.0))"
    call = f"plan_deeper(cap) + deepen(cap)[0] + plan_again(cap) + plan(cap) + {refused}"
    first = core.run(call)
    assert first.value == 125.0 + 125.0 + 139.0 + 139.0 - 2.0
    for _ in range(2):
        assert core.run(call) == Answer(first.value)


def test_another_root_translates_only_what_it_adds(core: TinyCore) -> None:
    core.run()
    assert core.run("plan(cap)") == Answer(139.0, "controller.cycle.plan", 2)
    assert core.run("plan(cap)") == Answer(139.0)
    # Translated for its callers, but not yet machine code of its own.
    assert core.run("limit_mm(1.0)") == Answer(6.0, "safety.limit.limit_mm", 0)


def test_what_calls_something_that_was_cleared_meanwhile_is_translated_anew(
    core: TinyCore,
) -> None:
    core.run("limit_mm(1.0)")
    (first,) = core.cache.rglob("*.translated")
    assert core.run("plan(cap)").value == 139.0
    first.unlink()
    for machine_code in (*core.cache.rglob("*.nbi"), *core.cache.rglob("*.nbc")):
        machine_code.unlink()
    assert core.run("plan(cap)") == Answer(139.0, "controller.cycle.plan", 3)


def test_what_another_type_of_argument_asks_for_is_translated(core: TinyCore) -> None:
    core.run("limit_mm(1.0)")
    assert core.run("limit_mm(1)") == Answer(6.0, "safety.limit.limit_mm", 1)


def test_what_is_linked_from_the_store_raises_with_its_values(core: TinyCore) -> None:
    assert core.run("plan(cap)").value == 139.0
    call = "refusal(plan_again, cap._replace(speed_mm_per_s=-2.0))"
    assert core.run(call) == Answer(-2.0, "controller.cycle.plan_again", 1)
    assert core.run(call) == Answer(-2.0)


def test_generated_code_of_one_name_is_not_mistaken_for_another(core: TinyCore) -> None:
    # Both are called ``scale``, and each process numbers what it translates from 1 on.
    assert core.run("double(1.0)").value == 2.0
    assert core.run("add_both(1.0)") == Answer(5.0, "controller.scale.add_both", 2)


def test_translations_for_another_processor_are_left_alone(core: TinyCore) -> None:
    core.run()
    (file,) = core.cache.rglob("*.translated")
    machine, contents = pickle.loads(file.read_bytes())
    file.write_bytes(pickle.dumps(((*machine[:1], "another", *machine[2:]), contents)))
    assert core.run("plan(cap)") == Answer(139.0, "controller.cycle.plan", 4)


def test_pruning_keeps_the_folder_in_use_and_the_most_recent(tmp_path: Path) -> None:
    folders = [tmp_path / f"{number:016x}" for number in range(6)]
    for age_s, folder in enumerate(folders):
        folder.mkdir()
        (folder / "code").touch()
        os.utime(folder, (1e9 - age_s, 1e9 - age_s))
    oldest = folders[-1]
    prune(tmp_path, keep=oldest, kept=3)
    assert sorted(tmp_path.iterdir()) == [folders[0], folders[1], oldest]


def test_a_cache_that_cannot_be_written_falls_back_to_the_temporary_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A file in the way stops the superuser too, whom permissions would not.
    (tmp_path / "file").touch()
    monkeypatch.setenv("OPENSUCTION_CACHE_DIR", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    root = module.cache_root()
    assert root.parent == tmp_path
    assert root.stat().st_mode & 0o077 == 0


def test_the_cache_follows_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENSUCTION_CACHE_DIR", str(tmp_path / "here"))
    assert module.cache_root() == tmp_path / "here"
    assert module.prepare_cache().parent == tmp_path / "here"
    assert module.prepare_cache().name == CACHE_FOLDER.name


@compiled
def pick(values: NDArray[np.float64], index: int) -> float:
    picked: float = values[index]
    return picked


@compiled
def divide(one: float, two: float) -> float:
    return one / two


def test_an_index_out_of_range_is_an_error_not_a_stray_number() -> None:
    assert pick(np.array([1.0, 2.0]), 1) == 2.0
    with pytest.raises(IndexError):
        pick(np.array([1.0, 2.0]), 2)


def test_a_division_by_zero_is_an_error_not_an_infinity() -> None:
    with pytest.raises(ZeroDivisionError):
        divide(1.0, 0.0)


def test_pruning_leaves_folders_that_are_not_caches(tmp_path: Path) -> None:
    keep = tmp_path / ("f" * 16)
    for name in ("Documents", "0123456789abcdeg", *(f"{i:016x}" for i in range(8)), keep.name):
        (tmp_path / name).mkdir()
    prune(tmp_path, keep)
    left = {entry.name for entry in tmp_path.iterdir()}
    assert {"Documents", "0123456789abcdeg", keep.name} <= left
    assert len(left) == 2 + module.KEPT_CACHES
