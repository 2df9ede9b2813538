import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "opensuction"
ARCHITECTURE = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
MAP = (ROOT / "docs" / "explanations" / "code-map.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| (?!behaviour \|).+ \| (.+) \|$", re.MULTILINE)
PATH = re.compile(r"`([\w/.]+)`")
MOST_ROWS = 25
"""A map that is read at a glance; the others are on the code map."""


def rooms() -> set[str]:
    return {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}


def cells() -> list[str]:
    """Second column of the table in ARCHITECTURE.md."""
    start = ARCHITECTURE.index("## Where is what")
    return ROW.findall(ARCHITECTURE[start : ARCHITECTURE.index("## Rooms")])


def places() -> list[tuple[str, str]]:
    """Room and path of each row of the code map."""
    parts = re.split(r"^## (\w+)$", MAP, flags=re.MULTILINE)[1:]
    tables = zip(parts[::2], parts[1::2], strict=True)
    return [
        (room, path)
        for room, table in tables
        for cell in ROW.findall(table)
        for path in PATH.findall(cell)
    ]


def test_the_map_of_the_architecture_is_short() -> None:
    assert 20 <= len(cells()) <= MOST_ROWS


def test_each_row_of_the_architecture_links_to_one_file() -> None:
    for cell in cells():
        found = re.fullmatch(r"\[`([\w/]+\.py)`\]\(src/opensuction/([\w/]+\.py)\)", cell)
        assert found, cell
        assert found[1] == found[2]
        assert (PACKAGE / found[1]).is_file()


def test_each_row_of_the_code_map_has_one_path_of_its_package() -> None:
    assert len(places()) == len(ROW.findall(MAP)) > 200
    assert [path for room, path in places() if not path.startswith(f"{room}/")] == []
    assert [path for _, path in places() if not (PACKAGE / path).exists()] == []


def test_every_room_is_on_the_code_map() -> None:
    assert {room for room, _ in places()} == rooms()


def test_every_room_is_in_the_table_of_rooms() -> None:
    table = ARCHITECTURE[ARCHITECTURE.index("## Rooms") : ARCHITECTURE.index("## A tick")]
    first = re.findall(r"^\| (`.+?) \|", table, re.MULTILINE)
    assert {name for cell in first for name in re.findall(r"`(\w+)`", cell)} == rooms()
