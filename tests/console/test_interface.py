"""Anything at every route, with each role: never a failure within, never an answer undocumented.

Schemathesis makes requests of what the interface says of itself, right ones and wrong ones.
"""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.errors import Unsatisfiable
from schemathesis import Case, GenerationMode
from schemathesis.checks import not_a_server_error
from schemathesis.core.result import Ok
from schemathesis.schemas import APIOperation
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from opensuction.console.app import VERSION
from opensuction.console.guard.limits import UNHURRIED
from tests.console.listening import listening
from tests.console.served import Served

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
]
ROLES = (None, "observer", "clinician", "engineer", "administrator")
TRIED: dict[str | None, Any] = {None: (), "clinician": pytest.mark.sweep}
"""Who may do least in `make test`, a clinician in `.ci/run`, the others in the long runs."""
FEW, MANY, MOST = 4, 24, 80
"""Requests of each kind to each route, for each role."""
LAST = ("DELETE", "/api/v1/session")
"""Signs out: nothing of that role can be asked after it."""
ANSWERS_S = 30.0


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder: Path = tmp_path_factory.mktemp("interface")
    with listening(folder, UNHURRIED) as made:
        yield made


def operations(console: Served) -> list[APIOperation[Any, Any, Any, Any]]:
    """What the interface says that it does."""
    schema = schemathesis.openapi.from_dict(console.app.openapi())
    results = list(schema.get_all_operations())
    found = [result.ok() for result in results if isinstance(result, Ok)]
    assert len(found) == len(results), "each of them can be understood"
    return sorted(found, key=lambda one: (one.method.upper(), one.path) == LAST)


def play(console: Served, role: str | None, examples: int) -> int:
    """Ask everything of everything; how often it was asked."""
    asked = 0
    headers, cookies = console.headers(role), console.cookies(role)

    def ask(case: Case[Any]) -> None:
        nonlocal asked
        asked += 1
        own = {name: value for name, value in headers.items() if name not in (case.headers or {})}
        response = case.call(base_url=console.url, headers=own, cookies=cookies, timeout=ANSWERS_S)
        case.validate_response(response, checks=CHECKS)

    for operation in operations(console):
        for mode in (GenerationMode.POSITIVE, GenerationMode.NEGATIVE):
            strategy = operation.as_strategy(generation_mode=mode)
            run = settings(
                max_examples=examples,
                deadline=None,
                derandomize=True,
                database=None,
                phases=(Phase.explicit, Phase.generate),
                suppress_health_check=list(HealthCheck),
            )(given(case=strategy)(ask))
            # A route that takes nothing can be asked nothing wrong.
            with suppress(Unsatisfiable):
                run()
    return asked


@pytest.mark.parametrize(
    "role",
    [pytest.param(one, marks=TRIED.get(one, pytest.mark.soak)) for one in ROLES],
)
def test_nothing_that_is_asked_fails_within_or_is_answered_as_nobody_said(
    console: Served, role: str | None
) -> None:
    assert play(console, role, FEW) > FEW * len(operations(console)) / 2


@pytest.mark.soak
@pytest.mark.parametrize("role", ROLES)
def test_the_same_with_many_more(tmp_path: Path, role: str | None) -> None:
    with listening(tmp_path, UNHURRIED) as console:
        assert play(console, role, MANY) > MANY * len(operations(console)) / 2


@pytest.mark.soak
@pytest.mark.parametrize("role", ROLES)
def test_the_same_with_most(tmp_path: Path, role: str | None) -> None:
    with listening(tmp_path, UNHURRIED) as console:
        assert play(console, role, MOST) > MOST * len(operations(console)) / 2


def test_each_refusal_of_each_route_is_a_problem(console: Served) -> None:
    told = console.app.openapi()
    assert told["info"]["version"] == VERSION
    for path, methods in told["paths"].items():
        assert path.startswith("/api/v1/")
        for method, route in methods.items():
            for status, answer in route["responses"].items():
                if int(status) >= 400:
                    assert list(answer["content"]) == ["application/problem+json"], (path, method)
            assert {"403", "413", "429"} <= set(route["responses"]), (path, method)
