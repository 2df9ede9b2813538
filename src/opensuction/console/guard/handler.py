"""Handlers that turn the exceptions of routes into problem+json, without details of the inside."""

from collections.abc import Sequence
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import Response

from opensuction.accounts.refusal import (
    BusyError,
    NotAllowedError,
    NotSignedInError,
    WaitError,
    WrongPasswordError,
)
from opensuction.console.guard import problem
from opensuction.console.guard.problem import FieldError, Problem
from opensuction.kernel.errors import InputError
from opensuction.records.database.failure import RecordsError
from opensuction.settings.wording import one_line

BODY_PARTS = frozenset({"body", "query", "path", "header", "cookie"})


def of_error(error: InputError) -> Problem:
    """The problem of an error that a person can cause."""
    if isinstance(error, NotSignedInError | WrongPasswordError):
        return Problem(401, str(error), headers={"WWW-Authenticate": "Bearer"})
    if isinstance(error, NotAllowedError):
        return Problem(403, str(error))
    if isinstance(error, WaitError):
        return Problem(429, str(error), headers={"Retry-After": str(error.wait_s)})
    if isinstance(error, BusyError | RecordsError):
        return Problem(503, str(error))
    return Problem(422, str(error))


def of_validation(errors: Sequence[Any]) -> Problem:
    """The problem of a request that has another shape; the values that were sent are not said."""
    found = []
    for one in errors:
        place = [str(part) for part in one.get("loc", ())]
        if len(place) > 1 and place[0] in BODY_PARTS:
            place = place[1:]
        found.append(FieldError(one_line(".".join(place))[:100], one_line(str(one["msg"]))[:200]))
    return Problem(422, "the request is not as it should be", found)


def add(app: FastAPI) -> None:
    """Have what routes raise answered as problems; what they should not, `guard` answers."""

    async def refuse(_: Request, error: Exception) -> Response:
        assert isinstance(error, Problem)
        return problem.answer(error)

    async def explain(_: Request, error: Exception) -> Response:
        assert isinstance(error, InputError)
        return problem.answer(of_error(error))

    async def validate(_: Request, error: Exception) -> Response:
        assert isinstance(error, RequestValidationError)
        return problem.answer(of_validation(error.errors()))

    async def say(_: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        headers = dict(error.headers or {})
        return problem.answer(Problem(error.status_code, one_line(str(error.detail)), (), headers))

    app.add_exception_handler(Problem, refuse)
    app.add_exception_handler(InputError, explain)
    app.add_exception_handler(RequestValidationError, validate)
    app.add_exception_handler(HTTPException, say)
