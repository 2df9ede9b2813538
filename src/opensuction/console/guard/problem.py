"""Refusal of a request: a problem+json with the reason in one plain line.

Source: [RFC-9457].

Handlers that turn the exceptions of routes into problem+json, without details of the inside.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel
from starlette.exceptions import HTTPException
from starlette.responses import Response

from opensuction.accounts.site import (
    BusyError,
    NotAllowedError,
    NotSignedInError,
    WaitError,
    WrongPasswordError,
)
from opensuction.kernel.errors import InputError
from opensuction.records.database.failure import RecordsError
from opensuction.settings.wording import one_line

MEDIA_TYPE = "application/problem+json"
TITLES = {
    400: "Bad request",
    401: "Not signed in",
    403: "Not allowed",
    404: "Not found",
    405: "Method not allowed",
    408: "Too slow",
    409: "Conflict",
    411: "No length",
    413: "Too large",
    415: "Of another kind",
    416: "No such range",
    421: "Another host",
    422: "Cannot be",
    429: "Too many",
    431: "Headers too large",
    500: "Failed",
    503: "Not now",
}


class FieldError(NamedTuple):
    """Error in one field of a request."""

    field: str
    """Its name; of one within others with dots between."""
    detail: str


class Problem(Exception):  # noqa: N818 - as the standard calls it
    """Raised where a request is refused."""

    def __init__(
        self,
        status: int,
        detail: str,
        errors: Iterable[FieldError] = (),
        headers: Mapping[str, str] | None = None,
    ) -> None:
        """detail: one plain line for a person. errors: what is wrong with which field."""
        super().__init__(detail)
        self.status, self.detail, self.errors = status, detail, tuple(errors)
        self.headers = dict(headers or {})


class ErrorBody(BaseModel):
    """One of `ProblemBody.errors`."""

    field: str
    detail: str


class ProblemBody(BaseModel):
    """A refusal, as the interface describes it."""

    type: str
    title: str
    status: int
    detail: str
    errors: list[ErrorBody] = []


def answer(problem: Problem) -> JSONResponse:
    """The refusal as an answer."""
    body: dict[str, Any] = {
        "type": "about:blank",
        "title": TITLES.get(problem.status, "Refused"),
        "status": problem.status,
        "detail": problem.detail,
    }
    if problem.errors:
        body["errors"] = [one._asdict() for one in problem.errors]
    return JSONResponse(body, problem.status, problem.headers, MEDIA_TYPE)


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """For ``responses=`` of a route: it may refuse with these.

    400, 413, 429 and the like of the guard are documented for every route by the application.
    """
    content = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/ProblemBody"}}}
    return {one: {"description": TITLES[one], "content": content} for one in statuses}


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
        return answer(error)

    async def explain(_: Request, error: Exception) -> Response:
        assert isinstance(error, InputError)
        return answer(of_error(error))

    async def validate(_: Request, error: Exception) -> Response:
        assert isinstance(error, RequestValidationError)
        return answer(of_validation(error.errors()))

    async def say(_: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        headers = dict(error.headers or {})
        return answer(Problem(error.status_code, one_line(str(error.detail)), (), headers))

    app.add_exception_handler(Problem, refuse)
    app.add_exception_handler(InputError, explain)
    app.add_exception_handler(RequestValidationError, validate)
    app.add_exception_handler(HTTPException, say)
