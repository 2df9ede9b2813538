"""The body of a request, taken whole before anything is done with it: small, and in time."""

import asyncio
import json
from typing import Any

from starlette.types import Message, Receive

from opensuction.console.guard.limits import Limits
from opensuction.console.guard.problem import Problem
from opensuction.kernel.requests import STOP
from opensuction.settings.wording import one_line, show


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
