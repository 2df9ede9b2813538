"""Check of a command's JSON object against the published schema."""

import json
from functools import cache
from pathlib import Path
from typing import Any

FILE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "results.schema.json"
TYPES: dict[str, type | tuple[type, ...]] = {
    "object": dict,
    "array": list,
    "string": str,
    "integer": int,
    "number": (int, float),
    "boolean": bool,
    "null": type(None),
}


@cache
def load() -> dict[str, Any]:
    """The schema as it is published."""
    found: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def find_faults(command: str, data: Any) -> list[str]:
    """What of a command's object is not as its schema has it; keys that it does not name, too."""
    return _faults(load()["$defs"][command], data, command)


def _faults(schema: dict[str, Any], data: Any, at: str) -> list[str]:
    """Of the keywords that the schema uses, and of no others."""
    if "$ref" in schema:
        return _faults(load()["$defs"][schema["$ref"].removeprefix("#/$defs/")], data, at)
    if "anyOf" in schema:
        by_kind = [_faults(one, data, at) for one in schema["anyOf"]]
        return min(by_kind, key=len)
    if "enum" in schema:
        return [] if data in schema["enum"] else [f"{at}: {data!r} is none of {schema['enum']}"]
    if not any(_is(data, name) for name in _listed(schema["type"])):
        return [f"{at}: {data!r} is no {schema['type']}"]
    if isinstance(data, dict):
        return _object_faults(schema, data, at)
    if isinstance(data, list):
        first = schema.get("prefixItems", [])
        kinds = first or [schema["items"]] * len(data)
        found: list[str] = [f"{at}: {len(data)} entries"] if len(kinds) != len(data) else []
        for number, (kind, one) in enumerate(zip(kinds, data, strict=False)):
            found += _faults(kind, one, f"{at}[{number}]")
        return found
    return []


def _object_faults(schema: dict[str, Any], data: dict[str, Any], at: str) -> list[str]:
    known, others = schema.get("properties", {}), schema.get("additionalProperties")
    found = [f"{at}: no {key}" for key in schema.get("required", []) if key not in data]
    for key, value in data.items():
        kind = known.get(key, others)
        found += (
            [f"{at}: {key} is not known"] if kind is None else _faults(kind, value, f"{at}.{key}")
        )
    return found


def _listed(types: str | list[str]) -> list[str]:
    return [types] if isinstance(types, str) else types


def _is(data: Any, name: str) -> bool:
    return isinstance(data, TYPES[name]) and (name == "boolean" or not isinstance(data, bool))
