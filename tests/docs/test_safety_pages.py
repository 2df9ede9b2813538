"""The reviewer's pages: every part of others was looked at, every test that is named exists."""

import ast
import re
from functools import cache
from importlib.metadata import requires, version
from pathlib import Path
from typing import Any

import llvmlite.binding
import numpy as np
import pytest
from packaging.requirements import Requirement
from scipy.optimize import nnls

from docs.generator.catalogue import DOCS
from docs.generator.safety import risk_table, soup_table, source_share
from opensuction.evidence.safety_case import hazard
from opensuction.evidence.safety_case.hazard_claim import Acceptability
from opensuction.kernel.errors import InputError
from opensuction.twin.parameter import BENCH

ROOT = DOCS.parent
SAFETY = DOCS / "safety"
NAMED = re.compile(r"`(tests/[\w/]+\.py)(?:::(\w+))?`")
LEVEL = re.compile(rf": \**({'|'.join(one.value for one in Acceptability)})\b")
NETWORK = {"asyncio", "ftplib", "http", "requests", "smtplib", "socket", "ssl", "urllib", "xmlrpc"}
UNPICKLING = {
    "evidence/worker_pool.py",  # speaks to workers that it started itself
    "evidence/worker.py",
    "kernel/compiler/store.py",  # the user's own folder of compiled code
}
SOURCES = ROOT / "src" / "opensuction"
VENDORED = SOURCES / "report" / "vendor" / "uPlot.iife.min.js"


def changed(monkeypatch: pytest.MonkeyPatch, row: int, **values: Any) -> None:
    """The data with one row changed."""
    data = soup_table.soup()
    data["package"][row] |= values
    monkeypatch.setattr(soup_table, "soup", lambda: data)


def brought(names: list[str]) -> set[str]:
    """What packages need at run time in this environment, themselves included."""
    found: set[str] = set()
    while names:
        name = names.pop()
        if name in found:
            continue
        found.add(name)
        for line in requires(name) or ():
            needed = Requirement(line)
            if needed.marker is None or needed.marker.evaluate({"extra": ""}):
                names.append(needed.name.lower().replace("_", "-"))
    return found


def test_every_version_was_reviewed() -> None:
    soup_table.check()


def test_another_version_asks_for_a_review(monkeypatch: pytest.MonkeyPatch) -> None:
    changed(monkeypatch, 0, reviewed=["0.1"])
    with pytest.raises(InputError, match=r"numba: reviewed 0\.1, requirements\.lock has .*look"):
        soup_table.check()


def test_a_new_dependency_asks_for_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    changed(monkeypatch, 0, name="numbat")
    with pytest.raises(InputError, match=r"numba of pyproject\.toml has no row"):
        soup_table.check()


def test_a_row_of_what_nothing_brings_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    changed(monkeypatch, 1, parent="nobody")
    with pytest.raises(InputError, match="llvmlite: nothing in the file brings it"):
        soup_table.check()


def test_what_comes_with_a_dependency_has_its_row_too() -> None:
    rows = {row["name"]: row for row in soup_table.soup()["package"]}
    needed = brought(list(soup_table.named()))
    assert needed - rows.keys() == set()
    for name in needed:
        assert version(name) in rows[name]["reviewed"], name


def test_the_platform_that_was_looked_at_is_the_one_that_is_here() -> None:
    versions = {row["name"]: row["version"] for row in soup_table.soup()["platform"]}
    llvm = llvmlite.binding.llvm_version_info
    assert versions["LLVM"] == f"{llvm[0]}.{llvm[1]}"
    assert f"(v{versions['uPlot']})" in VENDORED.read_text(encoding="utf-8")[:200]


def test_every_part_says_what_fails_and_what_guards() -> None:
    data = soup_table.soup()
    for row in (*data["package"], *data["platform"]):
        for key in ("used_for", "failure", "guard"):
            assert row[key].strip(), (row["name"], key)
        for anomaly in row.get("anomaly", ()):
            assert anomaly["guard"] or anomaly["touches"].startswith("no"), anomaly["issue"]


def test_an_issue_that_cannot_be_found_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    bad = {"issue": "numba 1833", "what": "a", "touches": "no", "guard": ""}
    changed(monkeypatch, 0, anomaly=[bad])
    with pytest.raises(InputError, match="'numba 1833' is no issue"):
        soup_table.markdown()


def test_nonnegative_least_squares_of_the_pinned_version_are_least() -> None:
    """scipy/scipy#25389: another version gave no minimum, and called its residual 0."""
    draw = np.random.default_rng(20261123)
    matrices = [np.array([[3.0, 2.0], [1.0, 1.0]])]
    sizes = [draw.integers(2, 6, 2) for _ in range(1000)]
    matrices += [draw.integers(-4, 5, tuple(size)).astype(float) for size in sizes]
    for matrix in matrices:
        aim = draw.integers(-4, 5, len(matrix)).astype(float)
        found, residual = nnls(matrix, aim)
        left = matrix @ found - aim
        slope = matrix.T @ left
        assert residual == pytest.approx(np.linalg.norm(left), abs=1e-9)
        assert (found >= 0.0).all()
        assert (slope >= -1e-9).all(), "less along an unknown that is 0"
        assert np.abs(slope * found).max() < 1e-9, "less along one that is not"


@cache
def imported() -> dict[str, set[str]]:
    """Modules that each source file imports, by its first name, and `eval` where it is called."""
    found: dict[str, set[str]] = {}
    for path in SOURCES.rglob("*.py"):
        names = found.setdefault(path.relative_to(SOURCES).as_posix(), set())
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names.add(str(node.module).split(".")[0])
            elif isinstance(node, ast.Call) and getattr(node.func, "id", "") == "eval":
                names.add("eval")
    return found


LOCAL = {"host/this_computer.py"}
"""Where processes of one machine send each other something."""
LISTENS = {"session/running/console_settings.py", "console/console_process.py"}
"""Where the console's port is opened: on this computer alone, or with a certificate."""


def test_nothing_opens_a_connection_or_listens_but_to_the_same_user_on_the_same_machine() -> None:
    """But the console, which listens, and connects to nothing."""
    assert len(imported()) > 200
    using = {file: names & NETWORK for file, names in imported().items() if names & NETWORK}
    outside = {file: used for file, used in using.items() if not file.startswith("console/")}
    console = {file for file, used in using.items() if "socket" in used} - LOCAL
    assert console == LISTENS
    assert set().union(*using.values()) <= {"asyncio", "http", "socket", "ssl"}
    outside.pop("session/running/console_settings.py")
    assert outside == {file: {"socket"} for file in LOCAL}
    for file in imported():
        text = (SOURCES / file).read_text(encoding="utf-8")
        connecting = ("create_connection", "open_connection", "urlopen", "httpx", ".connect((")
        assert not any(word in text for word in connecting), file
    for file in LOCAL:
        made = [
            node
            for node in ast.walk(ast.parse((SOURCES / file).read_text(encoding="utf-8")))
            if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("socket.")
        ]
        assert made
        assert all(ast.unparse(node.args[0]) == "socket.AF_UNIX" for node in made), file


def test_only_the_records_speak_to_a_database() -> None:
    """And so to a server, where a person names one."""
    drivers = {"sqlalchemy", "alembic", "psycopg", "sqlite3"}
    speaking = {file for file, names in imported().items() if names & drivers}
    assert {file.split("/")[0] for file in speaking} == {"records"}


def test_no_file_of_a_user_is_unpickled_or_evaluated() -> None:
    loading = {"pickle", "marshal", "shelve", "eval"}
    # Of the core's own source: what a loop that is written out goes over.
    own = {"kernel/codegen/unrolled.py"}
    assert {file for file, names in imported().items() if names & loading} - own == UNPICKLING


@cache
def definitions(path: Path) -> set[str]:
    """Names of the functions and classes of a file."""
    kinds = (ast.FunctionDef, ast.ClassDef)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, kinds)}


@pytest.mark.parametrize("page", sorted(SAFETY.glob("*.md")), ids=lambda page: page.name)
def test_every_test_that_a_page_names_exists(page: Path) -> None:
    for file, name in NAMED.findall(page.read_text(encoding="utf-8")):
        assert (ROOT / file).is_file(), file
        assert not name or name in definitions(ROOT / file), f"{file}::{name}"


def test_every_hazard_that_a_page_names_exists() -> None:
    known = {one.row.id for one in hazard.load()}
    for page in SAFETY.glob("*.md"):
        assert set(re.findall(r"OS-H\d\d", page.read_text(encoding="utf-8"))) <= known, page.name


@pytest.mark.parametrize("name", ["common-cause", "cybersecurity", "usability", "risk"])
def test_the_pages_that_claim_name_tests(name: str) -> None:
    text = (SAFETY / f"{name}.md").read_text(encoding="utf-8")
    assert len(set(NAMED.findall(text))) >= 15


def test_what_is_not_acceptable_is_said_in_words() -> None:
    """A reader of the page's text learns of each hazard that stays unacceptable."""
    text = (SAFETY / "risk.md").read_text(encoding="utf-8").split("<!--")[0]
    unacceptable = risk_table.unacceptable()
    assert unacceptable
    assert set(re.findall(r"OS-H\d\d", text)) == set(unacceptable)


def test_every_hazard_stands_in_the_table_with_both_of_its_risks() -> None:
    text = risk_table.markdown()
    rows = [line for line in text.splitlines() if line.startswith("| [OS-H")]
    assert len(rows) == len(hazard.load())
    for row in rows:
        assert len(LEVEL.findall(row)) == 2, row


def test_a_parameter_counts_by_its_first_source() -> None:
    some = next(iter(BENCH.values()))
    for source, kind in (
        ("[paper] 6.0 - 4.0", "paper"),
        ("[K] adult 40 to 90; [ATS-2000] child 10 to 20", "K"),
        ("[ATS-2000] child", "literature"),
    ):
        assert source_share.kind(some._replace(source=source)) == kind
    with pytest.raises(InputError, match="has no tag"):
        source_share.kind(some._replace(source="somebody said so"))
