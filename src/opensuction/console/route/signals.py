"""Signals at full rate: which there are, and a stream of those that are asked for.

Parameters of a request for signals: its channels, and how much of the past to send.
"""

import asyncio
import contextlib
import math
from typing import Annotated, NamedTuple

from fastapi import APIRouter, Depends, WebSocket, WebSocketDisconnect
from pydantic import BaseModel
from starlette.concurrency import run_in_threadpool
from starlette.requests import HTTPConnection

from opensuction.accounts import session
from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session
from opensuction.console import access
from opensuction.console.access import ConsoleContext, Here, Holder
from opensuction.console.guard import problem
from opensuction.console.guard.problem import FieldError, Problem, documented, of_error
from opensuction.console.signals.channel import CHANNELS, Channel, plain
from opensuction.console.signals.feed import FRAMES_PER_S, PAST_MOST_S, Feed, FullError, Subscriber
from opensuction.kernel.errors import InputError
from opensuction.records.database.failure import RecordsError

CHANNELS_MOST = 16
SHOWN = 60
"""Letters of an unknown name that are said again."""


def read_channels(asked: str) -> tuple[Channel, ...]:
    """Channels by their names, with commas between; raises Problem 422."""
    names = [name.strip() for name in asked.split(",", CHANNELS_MOST)] if asked.strip() else []
    if not names:
        raise _problem("channels", f"name 1 to {CHANNELS_MOST} channels, with commas between")
    if len(names) > CHANNELS_MOST:
        raise _problem("channels", f"{CHANNELS_MOST} channels at most at once")
    if len(set(names)) < len(names):
        raise _problem("channels", "a channel is named twice")
    for name in names:
        if name not in CHANNELS:
            shown = "".join(one if one.isprintable() else "?" for one in name[:SHOWN])
            raise _problem("channels", f"no channel '{shown}': see /api/v1/signals/channels")
    return tuple(CHANNELS[name] for name in names)


def read_past_s(asked: str | None) -> float:
    """Duration of past signals that is asked for, in s; raises Problem 422."""
    if asked is None:
        return 0.0
    try:
        wanted_s = float(asked) if len(asked) < SHOWN else math.nan
    except ValueError:
        wanted_s = math.nan
    if not 0.0 <= wanted_s <= PAST_MOST_S:
        raise _problem("past_s", f"should be a number of seconds from 0 to {PAST_MOST_S:g}")
    return wanted_s


def _problem(field: str, detail: str) -> Problem:
    return Problem(422, detail, [FieldError(field, detail)])


router = APIRouter(tags=["signals"])
CHECKS_S = 5.0
"""How often it is looked whether whoever looks still may."""
CLOSES_S = 1.0
"""For how long a client that takes nothing is asked to close."""
VIOLATED, LATER = 1008, 1013
"""Close codes of [RFC-6455]: against a rule; try again later."""


class ChannelBody(BaseModel):
    """A channel that can be asked for."""

    name: str
    title: str
    unit: str
    group: str
    origin: str
    is_exact: bool


class ChannelsBody(BaseModel):
    """All of them."""

    channels: list[ChannelBody]
    most: int
    frames_per_s: float


@router.get("/signals/channels", responses=documented(401, 403, 503))
def list_channels(_: Annotated[Holder, Depends(access.may(Right.SEE_SIGNALS))]) -> ChannelsBody:
    """Every channel that can be drawn, those of a group together."""
    found = [ChannelBody.model_validate(plain(one)) for one in CHANNELS.values()]
    return ChannelsBody(channels=found, most=CHANNELS_MOST, frames_per_s=FRAMES_PER_S)


def _allow(site: ConsoleContext, connection: HTTPConnection) -> Holder:
    """Holder of a request. Raises InputError where that person, or program, may not look."""
    holder = access.find_holder(site, connection)
    session.require(holder, Right.SEE_SIGNALS)
    return holder


def _allow_still(site: ConsoleContext, connection: HTTPConnection, holder: Holder) -> None:
    """Raises InputError where whoever looks may not any more. To look makes no session longer."""
    token = access.session_token(connection)
    if isinstance(holder, Session) and token is not None:
        holder = site.accounts.check_session(token)
    else:
        holder = access.find_holder(site, connection)
    session.require(holder, Right.SEE_SIGNALS)


def find_feed(site: ConsoleContext, websocket: WebSocket) -> Feed:
    """The one feed of an application, made when somebody asks for it."""
    state = websocket.app.state
    if not hasattr(state, "feed"):
        state.feed = Feed(site.folder)
    found: Feed = state.feed
    return found


@router.websocket("/signals")
async def stream(websocket: WebSocket, site: Here) -> None:
    """Rows of the asked channels as they come: see `console.signals.channel`; words as JSON."""
    try:
        channels = read_channels(websocket.query_params.get("channels", ""))
        past_s = read_past_s(websocket.query_params.get("past_s"))
        holder = await run_in_threadpool(_allow, site, websocket)
    except Problem as refused:
        await websocket.send_denial_response(problem.answer(refused))
        return
    except InputError as refused:
        await websocket.send_denial_response(problem.answer(of_error(refused)))
        return
    await _stream(websocket, Looker(site, holder, channels, past_s))


class Looker(NamedTuple):
    """Holder of a subscription, with the channels that it covers."""

    site: ConsoleContext
    holder: Holder
    channels: tuple[Channel, ...]
    past_s: float


async def _stream(websocket: WebSocket, looker: Looker) -> None:
    feed = find_feed(looker.site, websocket)
    try:
        async with feed.subscribed(looker.channels, looker.past_s) as subscriber:
            await websocket.accept()
            works = (
                asyncio.create_task(_send(websocket, subscriber)),
                asyncio.create_task(_listen(websocket)),
                asyncio.create_task(_watch(websocket, looker, feed, subscriber)),
            )
            try:
                done, _ = await asyncio.wait(works, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for work in works:
                    work.cancel()
            ends = [work.result() for work in done if work.exception() is None]
    except FullError:
        full = Problem(503, "as many look at signals as may: close another page, or try later")
        await websocket.send_denial_response(problem.answer(full))
        return
    if code_and_reason := next(filter(None, ends), None):
        with contextlib.suppress(TimeoutError, RuntimeError, WebSocketDisconnect):
            await asyncio.wait_for(websocket.close(*code_and_reason), CLOSES_S)


Ended = tuple[int, str] | None
"""Close code and reason; None: the client has gone."""


async def _send(websocket: WebSocket, subscriber: Subscriber) -> Ended:
    """All that waits, as fast as the client takes it."""
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        while True:
            message = await subscriber.take()
            if isinstance(message, bytes):
                await websocket.send_bytes(message)
            else:
                await websocket.send_text(message)
    return None


async def _listen(websocket: WebSocket) -> Ended:
    """Until the client goes; it has nothing to say here."""
    message = await websocket.receive()
    if message["type"] == "websocket.disconnect":
        return None
    return VIOLATED, "nothing is asked here: the channels are in the address"


async def _watch(websocket: WebSocket, looker: Looker, feed: Feed, subscriber: Subscriber) -> Ended:
    """Until the client takes nothing any more, or may not look any more."""
    while True:
        await asyncio.sleep(CHECKS_S)
        if subscriber in feed.stalled:
            return LATER, "too slow: nothing was taken for a while"
        try:
            await run_in_threadpool(_allow_still, looker.site, websocket, looker.holder)
        except RecordsError:
            continue  # The records cannot be read now: nobody is sent away for that.
        except InputError as refused:
            return VIOLATED, str(refused)[:120]
