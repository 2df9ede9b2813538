"""Reports and commands read results by attribute: a key that is misspelt is a type error."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[2] / "src" / "opensuction"
READERS = ("report", "cli")
GETTERS = ("get", "pop", "setdefault")
FUNCTIONS = ("number", "text", "value", "rows", "itemgetter")
"""Of a result and a key; `itemgetter` of a key alone."""
NO_RESULTS = {
    ("cli/interruption.py", "frame.f_globals"),  # Python's own
    ("report/airway_geometry.py", "kinds"),  # depths by kind, made in the same function
    ("report/series.py", "series"),  # curves by name, made in the same function
    ("report/series.py", "trace"),  # columns by name
    ("report/sheet.py", "data"),  # what the page's script reads, being made
}
"""Mappings that are read by a key, by file: each is no result."""


def list_readings(source: str) -> set[str]:
    """Mappings that a source reads by a key that stands in it."""
    return set(_find_readings(ast.parse(source)))


def _find_readings(tree: ast.Module) -> Iterator[str]:
    for node in ast.walk(tree):
        match node:
            case ast.Subscript(value=read, slice=ast.Constant(str()), ctx=ast.Load()):
                yield ast.unparse(read)
            case ast.Call(ast.Attribute(read, name), [ast.Constant(str()), *_]) if name in GETTERS:
                yield ast.unparse(read)
            case ast.Call(called, [*_, ast.Constant(str())]) if _name(called) in FUNCTIONS:
                yield ast.unparse(node)
            case ast.MatchMapping(keys=[ast.Constant(str()), *_]):
                yield ast.unparse(node)


def _name(called: ast.expr) -> str:
    return called.attr if isinstance(called, ast.Attribute) else ast.unparse(called)


def find_all() -> set[tuple[str, str]]:
    """File and mapping of every reading by a key in reports and commands."""
    files = [file for reader in READERS for file in (SOURCE / reader).rglob("*.py")]
    assert len(files) > 40
    return {
        (file.relative_to(SOURCE).as_posix(), read)
        for file in files
        for read in list_readings(file.read_text("utf-8"))
    }


def test_no_result_is_read_by_a_key() -> None:
    assert find_all() == NO_RESULTS


@pytest.mark.parametrize(
    ("source", "read"),
    [
        ("data['tip']", "data"),
        ("data['tip']['rmse_mm'] + 1", "data['tip']"),
        ("rows = [one['name'] for one in trips]", "one"),
        ("data.get('harm')", "data"),
        ("found.summary.get('harm', ())", "found.summary"),
        ("data.pop('trace', None)", "data"),
        ("number(data, 'tip', 'rmse_mm')", "number(data, 'tip', 'rmse_mm')"),
        ("summary.text(data, 'outcome')", "summary.text(data, 'outcome')"),
        ("value(data, 'seed')", "value(data, 'seed')"),
        ("rows(data, 'alarms')", "rows(data, 'alarms')"),
        ("sorted(trips, key=itemgetter('time_s'))", "itemgetter('time_s')"),
        ("match data:\n case {'outcome': outcome}: print(outcome)", "{'outcome': outcome}"),
    ],
)
def test_a_reading_by_a_key_is_found(source: str, read: str) -> None:
    assert read in list_readings(source)


@pytest.mark.parametrize(
    "source",
    [
        "result.tip.rmse_mm",
        "data['tip'] = 1",
        "columns[name]",
        "depths[0]",
        "tuple[str, ...]",
        "value(depth_mm, 2)",
        "'words'['time':]",
    ],
)
def test_another_reading_is_not(source: str) -> None:
    assert not list_readings(source)
