"""JSON Schema of the objects that commands print, from the records that these are made of."""

import ast
import inspect
import json
import re
import textwrap
from collections.abc import Mapping, Sequence
from enum import StrEnum
from itertools import pairwise
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

from opensuction.cli.command.audit import AuditResult
from opensuction.cli.command.cache import CacheResult
from opensuction.cli.command.inject import InjectionResult
from opensuction.cli.command.users import UsersResult
from opensuction.evidence.benchmark.benchmark import BenchmarkFigures
from opensuction.evidence.leaderboard.leaderboard import LeaderboardResult
from opensuction.evidence.lives.lives import LivesResult, PlayedLife
from opensuction.evidence.paper.reproduction import ReproductionResult
from opensuction.result.calibration_result import CalibrationResult
from opensuction.result.day_result import CycleAndDay
from opensuction.result.device_check_result import DeviceCheckResult
from opensuction.result.identification_result import (
    ComparisonResult,
    IdentificationResult,
    PredictionResult,
)
from opensuction.result.plain import FLAT, IF_FINITE, IF_KNOWN, Json
from opensuction.result.safety_case_result import SafetyCaseResult
from opensuction.result.trial_result import PlayedCycle, TrialResult
from opensuction.session.recorded.export_run import ExportResult
from opensuction.session.recorded.replay_run import ReplayResult, SeveralReplays
from opensuction.session.recorded.report_run import ReportedCycle
from opensuction.session.running.run import Answer, RunResult

DIALECT = "https://json-schema.org/draft/2020-12/schema"
ABOUT = (
    "The object that a command of opensuction prints with --json, by the command's name under "
    "$defs. In-silico, but for the figures of a recording of your own. More keys may come."
)
TYPES: dict[Any, str] = {
    bool: "boolean",
    int: "integer",
    float: "number",
    str: "string",
    type(None): "null",
}
Definitions = dict[Any, Json]
"""Schemas of the records within objects, by record."""
WIDTH = 100
"""Characters in a line of the file."""
WORDS = {"None": "null", "True": "true", "False": "false", "nan": "null"}
"""Words of docstrings, as JSON has them."""


class CommandObject(NamedTuple):
    """Record of a command's object, and which of its flat parts this command gives."""

    record: type
    always: tuple[str, ...] = ()
    never: tuple[str, ...] = ()


OBJECTS = {
    "cycle": CommandObject(CycleAndDay, ("simulated", "files"), ("recorded",)),
    "run": CommandObject(RunResult),
    "ask": CommandObject(Answer),
    "inject": CommandObject(InjectionResult),
    "identify": CommandObject(IdentificationResult),
    "compare": CommandObject(ComparisonResult),
    "predict": CommandObject(PredictionResult),
    "leaderboard": CommandObject(LeaderboardResult),
    "calibrate": CommandObject(CalibrationResult),
    "replay": CommandObject(ReplayResult),
    "replay-several": CommandObject(SeveralReplays),
    "report": CommandObject(ReportedCycle, ("recorded",), ("simulated",)),
    "export": CommandObject(ExportResult),
    "safety-case": CommandObject(SafetyCaseResult),
    "trial": CommandObject(TrialResult),
    "trial-play": CommandObject(PlayedCycle, ("simulated",), ("recorded", "files")),
    "simulate": CommandObject(LivesResult),
    "simulate-play": CommandObject(PlayedLife),
    "benchmark": CommandObject(BenchmarkFigures),
    "reproduce": CommandObject(ReproductionResult),
    "device": CommandObject(DeviceCheckResult),
    "audit": CommandObject(AuditResult),
    "users": CommandObject(UsersResult),
    "cache": CommandObject(CacheResult),
}
"""By command: ``trial-play`` of ``trial --play``, ``simulate-play`` likewise, ``replay-several`` of
more than one file."""


def schema() -> Json:
    """The schema of all commands."""
    definitions: Definitions = {}
    found = {name: _object(one.record, definitions, one) for name, one in OBJECTS.items()}
    inner = {_name(record): one for record, one in definitions.items()}
    if len(inner) < len(definitions):
        raise TypeError("two records of results have one name")
    return {
        "$schema": DIALECT,
        "title": "opensuction results",
        "description": ABOUT,
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in found],
        "$defs": found | dict(sorted(inner.items())),
    }


def text() -> str:
    """The same as the file holds it."""
    return _lay_out(schema()) + "\n"


def _lay_out(value: Any, indent: str = "") -> str:
    """JSON with a line for each value that fits into one."""
    line = json.dumps(value)
    if len(indent) + len(line) <= WIDTH or not isinstance(value, dict | list):
        return line
    inner = indent + " "
    if isinstance(value, list):
        ends, entries = "[]", [_lay_out(one, inner) for one in value]
    else:
        ends = "{}"
        entries = [f"{json.dumps(key)}: {_lay_out(one, inner)}" for key, one in value.items()]
    return f"{ends[0]}\n{inner}" + f",\n{inner}".join(entries) + f"\n{indent}{ends[1]}"


def _object(record: Any, definitions: Definitions, of: CommandObject | None = None) -> Json:
    """Schema of a record's object; the records within it become definitions.

    record: a NamedTuple, or a generic one of a type. of: where it is a command's own object.
    """
    own = get_origin(record) or record
    fields = _fields(record, definitions, of or CommandObject(own))
    return {
        "title": _title(record),
        "description": _write(inspect.getdoc(own) or ""),
        "type": "object",
        "properties": fields.properties,
        "required": fields.required,
    } | ({} if fields.others is None else {"additionalProperties": fields.others})


class _Fields(NamedTuple):
    """Fields of an object."""

    properties: Json
    required: list[str]
    """Those that are always written."""
    others: Json | None
    """Of a flat mapping: what its values are."""


def _fields(record: Any, definitions: Definitions, of: CommandObject) -> _Fields:
    """Fields of a record's object, those of its flat records among them."""
    own = get_origin(record) or record
    given = dict(zip(getattr(own, "__parameters__", ()), get_args(record), strict=True))
    words = _field_words(own)
    properties: Json = {}
    required: list[str] = []
    others: Json | None = None
    for name, field in get_type_hints(own, include_extras=True).items():
        hint, mark = get_args(field) if get_origin(field) is Annotated else (field, None)
        kinds = _members(given.get(hint, hint)) + ([NoneType] if mark == IF_FINITE else [])
        if mark == FLAT and get_origin(kinds[0]) is Mapping:
            others = _any_of(_members(get_args(kinds[0])[1]), definitions) | _said(words, name)
        elif mark == FLAT and name not in of.never:
            flat = [_fields(one, definitions, of) for one in kinds if one is not NoneType]
            properties |= _join([one.properties for one in flat])
            if NoneType not in kinds or name in of.always:
                required += flat[0].required
        elif mark != FLAT:
            if mark == IF_KNOWN:
                kinds = [one for one in kinds if one is not NoneType]
            else:
                required.append(name)
            properties[name] = _any_of(kinds, definitions) | _said(words, name)
    return _Fields(properties, required, others)


def _said(words: Mapping[str, str], name: str) -> Json:
    return {"description": words[name]} if name in words else {}


def _members(hint: Any) -> list[Any]:
    """What a value may be: the types of a union, or the one."""
    return list(get_args(hint)) if get_origin(hint) in (Union, UnionType) else [hint]


def _any_of(kinds: Sequence[Any], definitions: Definitions) -> Json:
    return _unite([_value(one, definitions) for one in kinds])


def _unite(schemas: Sequence[Json]) -> Json:
    """Schema of what any of these allows."""
    distinct = [one for number, one in enumerate(schemas) if one not in schemas[:number]]
    if len(distinct) == 1:
        return dict(distinct[0])
    if all(one.keys() == {"type"} for one in distinct):
        named = [one["type"] for one in distinct]
        every = [kind for one in named for kind in (one if isinstance(one, list) else [one])]
        return {"type": list(dict.fromkeys(every))}
    return {"anyOf": distinct}


def _join(parts: Sequence[Json]) -> Json:
    """Properties of records of which one stands there; all of them have the same keys."""
    if any(one.keys() != parts[0].keys() for one in parts):
        raise TypeError(f"records for one flat field differ in keys: {[list(p) for p in parts]}")
    found: Json = {}
    for key, first in parts[0].items():
        plain = [{k: v for k, v in one[key].items() if k != "description"} for one in parts]
        found[key] = _unite(plain) | _said(first, "description")
    return found


def _value(hint: Any, definitions: Definitions) -> Json:
    """Schema of a value of this type, which is no union."""
    own, inner = get_origin(hint), get_args(hint)
    if hasattr(own or hint, "_fields"):
        return {"$ref": f"#/$defs/{_define(hint, definitions)}"}
    if own is Literal:
        return {"enum": list(inner)}
    if own is Mapping:
        return {
            "type": "object",
            "additionalProperties": _any_of(_members(inner[1]), definitions),
        }
    if own is tuple and inner[-1] is not Ellipsis:
        items = [_any_of(_members(one), definitions) for one in inner]
        return {"type": "array", "prefixItems": items, "minItems": len(items), "items": False}
    if own in (tuple, list):
        return {"type": "array", "items": _any_of(_members(inner[0]), definitions)}
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        return {"enum": [one.value for one in hint]}
    if hint not in TYPES:
        raise TypeError(f"{hint} in a result: JSON lacks it")
    return {"type": TYPES[hint]}


def _define(record: Any, definitions: Definitions) -> str:
    """Name of a record's definition, which is made where it is not there yet."""
    if record not in definitions:
        definitions[record] = {}  # has its place while the records within it are defined
        definitions[record] = _object(record, definitions)
    return _name(record)


def _name(record: Any) -> str:
    parts = (get_origin(record) or record, *get_args(record))
    return "".join(one.__name__ for one in parts)


def _title(record: Any) -> str:
    name = (get_origin(record) or record).__name__
    return "".join(f" {one}" if one.isupper() else one for one in name).strip().lower()


def _field_words(record: type) -> dict[str, str]:
    """Docstrings of a record's fields, as they stand below them in its source."""
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(record))).body
    assert isinstance(tree, ast.ClassDef)
    found = {}
    for field, below in pairwise(tree.body):
        match field, below:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(ast.Constant(str(said))):
                found[name] = _write(inspect.cleandoc(said))
    return found


def _write(docstring: str) -> str:
    """A docstring in one line, in the words of JSON."""
    line = " ".join(docstring.replace("``", "`").split())
    return re.sub(rf"\b({'|'.join(WORDS)})\b", lambda found: WORDS[found[0]], line)
