"""Refusal of a request: a problem+json with the reason in one plain line.

Source: [RFC-9457].
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from fastapi.responses import JSONResponse
from pydantic import BaseModel

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
