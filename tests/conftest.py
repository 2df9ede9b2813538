"""Shared fixtures: components of the system, a browser, settings of Hypothesis.

Also saves time where several processes share the tests: each root is compiled by one of them. And
memory: what a file has kept for its tests goes with its last test.
"""

import ctypes
import fcntl
import gc
import hashlib
import os
import resource
import shutil
from collections.abc import Callable, Generator, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import Phase, settings

from opensuction.kernel.compiler.dispatcher import CoreFunction
from opensuction.records.database import database

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytest_plugins = ("tests.stage.plugin",)

Component = Callable[[str], Path]

COMPONENTS = {
    "chromium": ("chromium", "chromium-browser", "google-chrome"),
    "gcc": ("cc", "gcc"),
    "postgresql": ("initdb",),
}
"""Programs outside the lock that some tests need: by which names each may be found."""

CHROMIUM_OPTIONS = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu-watchdog"]
"""Its sandbox refuses root, and /dev/shm is 64 MB in containers. Only local pages here.

A computer that stands still is no drawing process that hangs: killed six times for it, it takes the
browser with it.
"""

REQUIRED = "OPENSUCTION_REQUIRE_COMPONENTS"
"""Set to 1, a missing component fails its tests instead of skipping them."""

# No deadline: the first example of a test may compile the core for seconds. The same examples
# every time: a test that fails for one person fails for all; the long run draws new ones.
settings.register_profile("suite", deadline=None, derandomize=True, database=None, max_examples=25)
settings.register_profile("soak", deadline=None, max_examples=5000, print_blob=True)
# A mutant only has to be noticed: the failing example need not be made small first.
settings.register_profile(
    "mutation",
    deadline=None,
    derandomize=True,
    database=None,
    max_examples=50,
    phases=(Phase.explicit, Phase.generate),
)
settings.load_profile(os.environ.get("OPENSUCTION_HYPOTHESIS", "suite"))


# Ten thousand tests and the machine code they use are what the collector would look through again
# and again: a seventh of the processor time of stage one.
gc.set_threshold(50_000, 20, 50)


GROWN_MB = 100.0
"""By which a process has grown when it looks for what it no longer needs: that takes a second."""

ORDER = (
    "tests/evidence/paper/test_paper_figures.py",  # the closed loop is compiled, all kinds of it
    "src/",
    "tests/kernel/",  # meanwhile what needs none of it
    "tests/mutation/",
    "tests/docs/",
    "tests/traceability/",
    "tests/settings/",
    "tests/report/",
    "tests/recording/",
    "tests/hysteresis/",
    "tests/identification/",
    "tests/controller/test_cycle.py",  # the loop with falsified readings
    "tests/controller/test_exploration.py",  # the loop with its links
    "tests/",
    "tests/kernel/test_denormals.py",
    "tests/controller/",
    "tests/runtime/test_embedded_controller.py",  # what the call is compiled for elsewhere
)
"""In which order the first tests of these folders run: no two processes wait for one compilation.

The longest beginning of a name counts; `make test` hands files out in this order.
"""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    def place(item: pytest.Item) -> int:
        fitting = [prefix for prefix in ORDER if item.nodeid.startswith(prefix)]
        return ORDER.index(max(fitting, key=len, default="tests/"))

    items.sort(key=place)


def pytest_collection_finish() -> None:
    gc.collect()
    gc.freeze()  # the tests themselves live until the end


def _resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 2**20


class Memory:
    """What this process holds."""

    least_mb = 0.0
    """After the last look."""

    @classmethod
    def give_back(cls) -> None:
        """Let go what nobody refers to, if it has become much.

        By itself the C library keeps what a compilation needed, for some allocation to come.
        """
        if _resident_mb() < cls.least_mb + GROWN_MB:
            return
        gc.collect()
        with suppress(AttributeError):  # another C library
            ctypes.CDLL(None).malloc_trim(0)
        cls.least_mb = _resident_mb()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(
    item: pytest.Item, nextitem: pytest.Item | None
) -> Generator[None, None, None]:
    """With the last test of a file goes what its functions have kept: nobody asks for it again."""
    yield
    if nextitem is None or nextitem.path != item.path:
        names: dict[str, Any] = vars(item.module) if isinstance(item, pytest.Function) else {}
        for one in names.values():
            if hasattr(one, "cache_clear") and one.__module__ == names["__name__"]:
                one.cache_clear()
        Memory.give_back()


@pytest.fixture(scope="session", autouse=True)
def _compiled_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Of the processes that share these tests one compiles a root; the others wait, and load it."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        yield
        return
    folder = tmp_path_factory.getbasetemp().parent  # of all these processes
    build = CoreFunction._build

    def build_or_load(root: CoreFunction, sig: Any, args: tuple[Any, ...]) -> Any:
        function = f"{root.py_func.__module__}.{root.py_func.__qualname__}{args}"
        name = hashlib.sha256(function.encode()).hexdigest()[:16]
        with (folder / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            found = root._load(sig)
            if found is None:
                found = build(root, sig, args)
                Memory.give_back()
            return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(CoreFunction, "_build", build_or_load)
        yield


@pytest.fixture(scope="session", autouse=True)
def _no_disk_awaited() -> Iterator[str]:
    """No commit of these processes waits for the disk: a computer that dies is no test's point."""
    shipped = database.DURABLE
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(database, "DURABLE", "PRAGMA synchronous = OFF")
        yield shipped


@pytest.fixture
def disk_awaited(_no_disk_awaited: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commits as the program makes them."""
    monkeypatch.setattr(database, "DURABLE", _no_disk_awaited)


@pytest.fixture(scope="session")
def component() -> Component:
    """Path of a program by the name of its component; skips, or fails, where it is missing."""

    def find(name: str) -> Path:
        for program in COMPONENTS[name]:
            found = shutil.which(program)
            if found is not None:
                return Path(found)
        missing = f"{name} is not installed; for example: apt-get install {name}"
        if os.environ.get(REQUIRED) == "1":
            pytest.fail(f"{missing} ({REQUIRED}=1 forbids to skip)")
        pytest.skip(missing)

    return find


@pytest.fixture(scope="module")
def chromium(component: Component) -> Iterator["Browser"]:
    """The system's Chromium, headless, driven by Playwright.

    It ends with the file that wanted it: one that lay idle until all tests were through might not
    live to see that, and the last test of the process would be blamed.
    """
    program = component("chromium")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=CHROMIUM_OPTIONS)
        yield browser
        browser.close()
