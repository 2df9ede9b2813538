import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "opensuction"
TEXT = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
QUOTED = re.compile(r"`([a-z0-9_/]+/|[a-z0-9_/]+\.py)`")


def places() -> list[tuple[str, Path]]:
    """Each file and folder of the table, a bare name read in the folder named before it."""
    table = TEXT[TEXT.index("## Where is what") : TEXT.index("## Rooms")]
    found = []
    for row in table.splitlines():
        folder = PACKAGE
        for name in QUOTED.findall(row):
            place = PACKAGE / name
            if not place.exists():
                place = folder / name
            if not place.exists():
                place = folder.parent / name
            folder = place if name.endswith("/") else place.parent
            found.append((name, place))
    return found


def test_every_place_of_the_map_exists() -> None:
    assert len(places()) > 50
    missing = [name for name, place in places() if not place.exists()]
    assert missing == []


def test_every_room_is_on_the_map() -> None:
    rooms = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    mapped = {place.relative_to(PACKAGE).parts[0] for _, place in places()}
    assert mapped == rooms
