"""Signals at full rate: which there are, and a stream of those that are asked for."""

import asyncio
import contextlib
from typing import Annotated, NamedTuple

from fastapi import APIRouter, Depends, WebSocket, WebSocketDisconnect
from pydantic import BaseModel
from starlette.concurrency import run_in_threadpool
from starlette.requests import HTTPConnection

from opensuction.accounts import session
from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session
from opensuction.console import access
from opensuction.console.access import Here, Holder
from opensuction.console.guard import problem
from opensuction.console.guard.handler import of_error
from opensuction.console.guard.problem import Problem, documented
from opensuction.console.signals import signal_request
from opensuction.console.signals.channel import CHANNELS, Channel, plain
from opensuction.console.signals.feed import FRAMES_PER_S, Feed, FullError
from opensuction.console.signals.signal_request import CHANNELS_MOST
from opensuction.console.signals.subscriber import Subscriber
from opensuction.console.site import ConsoleContext
from opensuction.kernel.errors import InputError
from opensuction.records.database.failure import RecordsError

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
    """Rows of the asked channels as they come: see `console.signals.frame`; words as JSON."""
    try:
        channels = signal_request.read_channels(websocket.query_params.get("channels", ""))
        past_s = signal_request.read_past_s(websocket.query_params.get("past_s"))
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
