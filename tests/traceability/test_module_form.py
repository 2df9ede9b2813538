"""Check of the form of modules: docstrings that do not ask, names that are not shared."""

import textwrap
from pathlib import Path

import pytest

from tools.traceability import module_form


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("What the drives are told.", "What"),
        ("whether mucus comes.", "whether"),
        ("Who's there.", "Who"),
        ("Whose machine it is.", "Whose"),
        ("\n    How long it lasts.", "How"),
        ("Where the head is.", "Where"),
        ('"When" a cycle is due.', "When"),
        ("Which database.", "Which"),
        ("Why: a start is refused.", "Why"),
    ],
)
def test_a_question_word_is_found(text: str, word: str) -> None:
    assert module_form.question_word(f"'''{text}'''\nX = 1\n") == word


@pytest.mark.parametrize(
    "source",
    [
        '"""Commands to the drives and their replies."""\n',
        '"""Whatever is read, kept."""\n',
        '"""However, a line."""\n',
        '"""Explain how a cycle ended.\n\nWhat follows is not looked at.\n"""\n',
        'def ask() -> None:\n    """What is asked."""\n',
        "# What a comment says is its own.\n",
        "",
    ],
)
def test_any_other_beginning_is_none(source: str) -> None:
    assert module_form.question_word(source) is None


def test_each_module_is_one_line_with_the_word_and_the_remedy() -> None:
    sources = {
        "src/b.py": '"""How."""',
        "src/c.py": '"""A pump."""',
        "benchmarks/a.py": '"""Why."""',
    }
    assert module_form.problems(sources) == [
        'src/b.py: its docstring opens with "How"; name the thing, or say what it does',
        'benchmarks/a.py: its docstring opens with "Why"; name the thing, or say what it does',
    ]


DEFINITIONS = textwrap.dedent(
    '''
    """Valve."""

    class Valve:
        """What closes the line."""

        is_open: bool
        """Whether it is open: fields are not looked at."""

        @property
        def is_closed(self) -> bool:
            """Whether it is closed."""

        def close(self) -> None:
            """Close it. What follows a first sentence is not looked at."""

    async def wait() -> None:
        def until() -> float:
            """When it closes."""

        # Why nothing is said of it.

    def stroke_s() -> float:
        """Time of a stroke."""
    '''
)


def test_a_definition_that_asks_is_found_at_any_depth_with_its_line_and_name() -> None:
    assert module_form.asking_definitions(DEFINITIONS) == [
        (4, "Valve", "What"),
        (11, "is_closed", "Whether"),
        (18, "until", "When"),
    ]


@pytest.mark.parametrize(
    "definition",
    [
        'def is_open() -> bool:\n    """True while the valve is open."""\n',
        'class Wait:\n    """Whatever is awaited."""\n',
        "def how() -> None:\n    return\n",
        'X = 1\n"""How many there are."""\n',
    ],
)
def test_any_other_definition_is_in_form(definition: str) -> None:
    assert module_form.asking_definitions(definition) == []


@pytest.mark.parametrize(
    ("name", "refused"),
    [
        ("src/opensuction/safety/watch/valve_axis.py", True),
        ("src/opensuction/kernel/vocabulary.py", True),
        ("src/opensuction/__init__.py", True),
        ("tools/proof/logic.py", True),
        ("tests/safety/test_valve_axis.py", False),
        ("benchmarks/loop.py", False),
    ],
)
def test_definitions_of_product_and_tools_are_refused(name: str, refused: bool) -> None:
    source = 'def is_open() -> bool:\n    """Whether the valve is open."""\n'
    line = (
        f'{name}:1: the docstring of is_open opens with "Whether"; name the thing, or say what it '
        "does"
    )
    assert module_form.problems({name: source}) == [line] * refused


def test_a_name_is_there_once_in_a_package_of_the_product() -> None:
    shared = ["src/opensuction/a/b/limit.py", "src/opensuction/a/limit.py"]
    others = [
        "src/opensuction/c/limit.py",
        "src/opensuction/a/__init__.py",
        "src/opensuction/a/b/__init__.py",
        "tests/a/limit.py",
        "tests/a/b/limit.py",
    ]
    assert module_form.problems(dict.fromkeys(shared + others, "")) == [
        f"{', '.join(shared)}: one name in one package; say in it what each is of"
    ]


def test_the_folders_that_are_type_checked_are_read(tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text('[tool.mypy]\nfiles = ["src", "tests"]\n')
    for name in ("src/room/b.py", "tests/a.py", "build/c.py"):
        path = tmp_path / name
        path.parent.mkdir(parents=True)
        path.write_text(f'"""What {name} is."""\n')
    (tmp_path / "src" / "notes.md").write_text("What is not Python.\n")
    assert list(module_form.read(tmp_path)) == ["src/room/b.py", "tests/a.py"]
