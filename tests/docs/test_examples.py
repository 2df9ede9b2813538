"""The examples of README, tutorials and how-to guides run as they stand, and print what is shown.

Blocks of a page run in order, in a folder of the page's own: ``sh`` by bash, ``python`` in one
namespace, ``toml`` is saved under the name in its first line. A ``text`` block is what the command
before it prints: its words must come in that order, ``...`` stands for anything between. A comment
before a block says what a reader need not see: ``<!-- exit: 2 -->`` its exit status,
``<!-- not run: reason -->`` that it does not run here.
"""

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from markdown_it import MarkdownIt

from tests.docs import forked_command

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs" / "tutorials").glob("*.md")),
    *sorted((ROOT / "docs" / "how-to").glob("*.md")),
    ROOT / "docs" / "notebooks" / "index.md",
    ROOT / "docs" / "reference" / "library.md",
]
IN_FULL = {ROOT / "README.md"}
"""Pages whose commands begin as a reader's do; those of the others are forked from a warm one."""
COMMENT = re.compile(r"<!--\s*(exit|not run):\s*(.*?)\s*-->")
TIMEOUT_S = 600.0
INSTALLED = Path(sys.executable).parent
"""Where ``opensuction`` is as a person calls it."""


class Block(NamedTuple):
    language: str
    text: str
    line: int
    exit_status: int
    runs: bool


class Reader(NamedTuple):
    """What somebody who follows a page has: a folder, Python's names, what was printed last."""

    folder: Path
    names: dict[str, Any]
    printed: list[str]
    programs: Path


def blocks(text: str) -> list[Block]:
    found, said = [], {}
    for token in MarkdownIt().parse(text):
        if token.type == "html_block":
            said = dict(COMMENT.findall(token.content))
        elif token.type == "fence":
            runs = "not run" not in said
            status = int(said.get("exit", "0"))
            line = token.map[0] + 1 if token.map else 0
            found.append(Block(token.info, token.content, line, status, runs))
            said = {}
    return found


def is_slow(page: Path) -> bool:
    return any(block.language == "sh" and block.runs for block in blocks(page.read_text("utf-8")))


def is_live(page: Path) -> bool:
    """It begins a machine in real time."""
    shown = [block.text for block in blocks(page.read_text("utf-8")) if block.runs]
    return any(re.search(r"^\s*opensuction (run|serve)\b", text, re.MULTILINE) for text in shown)


def marks(page: Path) -> list[pytest.MarkDecorator]:
    found = [pytest.mark.examples] if is_slow(page) else []
    # What `run` does is tested in `tests/cli/test_run.py`: the page's words can wait.
    return found + ([pytest.mark.real_time, pytest.mark.soak] if is_live(page) else [])


def run_shell(block: Block, reader: Reader) -> None:
    path = os.pathsep.join((str(reader.programs), str(INSTALLED), os.environ["PATH"]))
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", block.text],
        cwd=reader.folder,
        env={**os.environ, "PATH": path, "COLUMNS": "80"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert done.returncode == block.exit_status, done.stdout
    # Pages show what is printed once the core is compiled.
    lines = done.stdout.splitlines(keepends=True)
    reader.printed.append("".join(line for line in lines if not line.startswith("Compil")))


def run_python(block: Block, reader: Reader) -> None:
    exec(compile(block.text, f"line {block.line}", "exec"), reader.names)  # noqa: S102 - our page


def save(block: Block, reader: Reader) -> None:
    name = block.text.splitlines()[0].removeprefix("# ")
    assert re.fullmatch(r"[\w./-]+\.toml", name), "the first line must be '# NAME.toml'"
    (reader.folder / name).parent.mkdir(exist_ok=True)
    (reader.folder / name).write_text(block.text, encoding="utf-8")


def compare(block: Block, reader: Reader) -> None:
    printed = " ".join(reader.printed[-1].split())
    for part in block.text.split("..."):
        words = " ".join(part.split())
        assert words in printed, f"not printed, or not in this order: {words}\n\n{printed}"
        printed = printed.split(words, 1)[1] if words else printed


STEPS = {"sh": run_shell, "python": run_python, "toml": save, "text": compare}


def follow(page: Path, folder: Path, programs: Path = INSTALLED) -> None:
    (folder / "docs").symlink_to(ROOT / "docs")
    reader = Reader(folder, {}, [], programs)
    for block in blocks(page.read_text("utf-8")):
        if block.runs and block.language in STEPS:
            STEPS[block.language](block, reader)


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Folder of an ``opensuction`` that need not begin anew for each command."""
    with forked_command.folder_of(tmp_path_factory.mktemp("warm")) as folder:
        yield folder


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=marks(page)) for page in PAGES if blocks(page.read_text("utf-8"))],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_the_examples_of_a_page_run(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.chdir(tmp_path)
    in_full = page in IN_FULL or not is_slow(page) or is_live(page)
    follow(page, tmp_path, INSTALLED if in_full else request.getfixturevalue("warm"))


@pytest.mark.examples
@pytest.mark.parametrize("line", ["--version", "cycle --patient somebody", "users --json"])
def test_a_forked_command_ends_as_one_of_its_own_process(
    line: str, warm: Path, tmp_path: Path
) -> None:
    block = Block("sh", f"opensuction {line} 2> told || echo $?\ncat told", 1, 0, runs=True)
    own, forked = (Reader(tmp_path, {}, [], folder) for folder in (INSTALLED, warm))
    run_shell(block, own)
    run_shell(block, forked)
    assert forked.printed == own.printed != [""]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_block_says_what_it_is(page: Path) -> None:
    unknown = [
        f"line {block.line}: '{block.language}'"
        for block in blocks(page.read_text("utf-8"))
        if block.language not in STEPS and not block.language.startswith("{")
    ]
    assert not unknown


def page_of(folder: Path, text: str) -> Path:
    page = folder / "page.md"
    page.write_text(text, encoding="utf-8")
    return page


def test_what_is_printed_must_be_what_is_shown(tmp_path: Path) -> None:
    text = "```sh\necho one two; echo three\n```\n\n```text\none\n...\nthree\n```\n"
    follow(page_of(tmp_path, text), tmp_path)


@pytest.mark.parametrize("shown", ["four", "three ... one", "one three"])
def test_what_is_not_printed_is_found_out(tmp_path: Path, shown: str) -> None:
    text = f"```sh\necho one two; echo three\n```\n\n```text\n{shown}\n```\n"
    with pytest.raises(AssertionError, match="not printed"):
        follow(page_of(tmp_path, text), tmp_path)


def test_an_example_that_fails_is_found_out(tmp_path: Path) -> None:
    with pytest.raises(AssertionError):
        follow(page_of(tmp_path, "```sh\nfalse\n```\n"), tmp_path)


def test_comments_give_the_exit_status_and_leave_out(tmp_path: Path) -> None:
    text = "<!-- exit: 3 -->\n```sh\nexit 3\n```\n\n<!-- not run: why -->\n```sh\nfalse\n```\n"
    follow(page_of(tmp_path, text), tmp_path)


def test_a_file_is_saved_under_the_name_in_its_first_line(tmp_path: Path) -> None:
    text = '```toml\n# runs/mine.toml\na = 1\n```\n\n```sh\ngrep -q "a = 1" runs/mine.toml\n```\n'
    follow(page_of(tmp_path, text), tmp_path)


def test_python_blocks_share_their_names(tmp_path: Path) -> None:
    text = "```python\na = 1\n```\n\n```python\nassert a == 1\n```\n"
    follow(page_of(tmp_path, text), tmp_path)
