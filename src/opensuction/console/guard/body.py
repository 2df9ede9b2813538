"""The body of a request, taken whole before anything is done with it: small, and in time.

The header Range: one range of bytes is obeyed, everything else of it is ignored.

Source: [RFC-9110] 14.1.1, 14.2: a unit that is not known must be ignored, what is invalid and
several ranges may be; only a valid range that a file has no part of is refused with 416.
"""

import asyncio
import json
import re
from collections.abc import Iterable
from typing import Any, NamedTuple

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from opensuction.console.guard import problem
from opensuction.console.guard.limits import Limits
from opensuction.console.guard.problem import Problem
from opensuction.kernel.interface import STOP
from opensuction.settings.wording import one_line, show

NAME = b"range"
UNIT = "bytes"
SPACE = " \t"
"""May stand around the elements of a header's list."""
UNSATISFIABLE = 416
FORM = re.compile(r"(?P<first>[0-9]+)-(?P<last>[0-9]*)|-(?P<length>[0-9]+)")
MOST_DIGITS = 18
"""Of a number that is told apart: no file is as long as the largest of them."""

Header = tuple[bytes, bytes]


class ByteRange(NamedTuple):
    """One range of the bytes of a file."""

    first: int | None
    """None: counted from the end."""
    last: int | None
    """The last byte, or how many from the end; None: to the end."""

    def find_start(self, size: int) -> int | None:
        """The first byte of a file of this size; None: it has no part of the range."""
        if self.first is not None:
            return self.first if self.first < size else None
        return max(0, size - (self.last or 0)) if self.last and size else None

    def __str__(self) -> str:
        """As a header says it."""
        first, last = ("" if one is None else str(one) for one in self)
        return f"{UNIT}={first}-{last}"


def read_byte_range(told: str | None) -> ByteRange | None:
    """The range that a header asks for; None where it is to be ignored, or there is none."""
    unit, _, listed = (told or "").partition("=")
    if unit.lower() != UNIT:
        return None
    elements = [one for one in (part.strip(SPACE) for part in listed.split(",")) if one]
    found = FORM.fullmatch(elements[0]) if len(elements) == 1 else None
    if found is None:
        return None
    if found["length"] is not None:
        return ByteRange(None, _to_number(found["length"]))
    first, last = _to_number(found["first"]), found["last"]
    if not last:
        return ByteRange(first, None)
    return ByteRange(first, _to_number(last)) if first <= _to_number(last) else None


def _to_number(digits: str) -> int:
    """The number, or the largest one that is told apart, whatever its length."""
    digits = digits.lstrip("0") or "0"
    return int(digits) if len(digits) <= MOST_DIGITS else 10**MOST_DIGITS


def _keep_valid(headers: Iterable[Header]) -> list[Header]:
    """The headers of a request: a range that is to be ignored is left out, another one is plain."""
    others: list[Header] = []
    told: list[Header] = []
    for name, value in headers:
        (told if name == NAME else others).append((name, value))
    found = read_byte_range(told[0][1].decode("latin-1")) if len(told) == 1 else None
    return others if found is None else [*others, (NAME, str(found).encode())]


class Ranges:
    """Around the application: it meets valid ranges only, and explains what it refuses."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See ASGI."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        is_refused = False

        async def answer(message: Message) -> None:
            nonlocal is_refused
            if message.get("status") == UNSATISFIABLE:  # of a file, without words
                is_refused = True
                await problem.answer(_refuse(message))(scope, receive, send)
            elif not is_refused:
                await send(message)

        await self.app({**scope, "headers": _keep_valid(scope["headers"])}, receive, answer)


def _refuse(message: Message) -> Problem:
    size = Headers(raw=message.get("headers", [])).get("content-range", f"{UNIT} */*")
    detail = "the file has no byte of the range that the header Range asks for"
    return Problem(UNSATISFIABLE, detail, headers={"Content-Range": size})


class GoneError(Exception):
    """Whoever asked has gone."""


def check_length(limits: Limits, said: str | None) -> None:
    """Raises Problem for a Content-Length that is too long or none."""
    if said is None:
        return
    if not (said.isascii() and said.isdigit()):
        raise Problem(400, "the length of the body is no number")
    if len(said) > len(str(limits.body_bytes)) or int(said) > limits.body_bytes:
        raise _too_large(limits)


async def read(limits: Limits, receive: Receive) -> bytes:
    """The whole body. Raises Problem where it is too long or too slow, GoneError."""
    found = bytearray()
    try:
        async with asyncio.timeout(limits.body_s):
            while True:
                message = await receive()
                if message["type"] == "http.disconnect":
                    raise GoneError
                found += message.get("body", b"")
                if len(found) > limits.body_bytes:
                    raise _too_large(limits)
                if not message.get("more_body", False):
                    return bytes(found)
    except TimeoutError:
        detail = f"the body did not come within {limits.body_s:g} s"
        raise Problem(408, detail, headers={"Connection": "close"}) from None


def check_keys(body: bytes, is_press: bool) -> None:
    """Raises Problem for a body of JSON that says a key twice: nobody knows which is meant.

    is_press: of a button; one that stops is obeyed, whatever else its body says.
    What is no JSON at all is for the application to refuse.
    """
    repeated: list[str] = []

    def take(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key, value in pairs:
            if key in found:
                repeated.append(key)
            found[key] = value
        return found

    try:
        told = json.loads(body, object_pairs_hook=take)
    except (ValueError, RecursionError):
        return
    stops = is_press and isinstance(told, dict) and told.get("ask") == STOP
    if repeated and not stops:
        raise Problem(400, one_line(f"the body says {show(repeated[0])} more than once"))


def _too_large(limits: Limits) -> Problem:
    detail = f"the body is longer than {limits.body_bytes} bytes"
    return Problem(413, detail, headers={"Connection": "close"})


def again(body: bytes, receive: Receive) -> Receive:
    """Receiver that repeats a body already read, then passes on what comes next."""
    is_given = False

    async def give() -> Message:
        nonlocal is_given
        if not is_given:
            is_given = True
            return {"type": "http.request", "body": body, "more_body": False}
        return await receive()

    return give
