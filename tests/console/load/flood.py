"""A flood, as a process: ``python -m tests.console.load.flood PORT CONNECTIONS RATE KIND``.

So many connections, which together ask so often a second or as often as they can. It goes on until
it is killed.
"""

import asyncio
import contextlib
import sys
from collections.abc import Awaitable, Callable

HOST = "127.0.0.1"
BODY = b'{"ask":"abort","key":"the-same-key-each-time"}'
PENDING_BYTES = 65_536
AGAIN_S = 0.05
"""After which a connection that was closed is made anew."""

Flooder = Callable[[int, float], Awaitable[None]]
"""One connection until it is closed, by port and rate, Hz."""


def press_of(port: int) -> bytes:
    """A press of *Stop*, whole."""
    return (
        f"POST /api/v1/requests HTTP/1.1\r\nHost: {HOST}:{port}\r\nContent-Length: {len(BODY)}\r\n"
        "Content-Type: application/json\r\n\r\n"
    ).encode() + BODY


def read_of(port: int) -> bytes:
    """A request for all that is known of the machine."""
    return f"GET /api/v1/state HTTP/1.1\r\nHost: {HOST}:{port}\r\n\r\n".encode()


async def press_unheard(port: int, rate_hz: float) -> None:
    """Press whether it is answered or not: what the console does not read waits in the socket."""
    reader, writer = await asyncio.open_connection(HOST, port)
    listening = asyncio.create_task(_drain(reader))
    while not writer.is_closing() and not listening.done():
        if writer.transport.get_write_buffer_size() < PENDING_BYTES:
            writer.write(press_of(port))
        await asyncio.sleep(1.0 / rate_hz)
    writer.close()


async def ask_on(port: int, rate_hz: float, request: bytes) -> None:
    """Ask, hear the answer, ask again."""
    reader, writer = await asyncio.open_connection(HOST, port)
    with contextlib.closing(writer):
        while await _answer(reader, writer, request):
            await asyncio.sleep(1.0 / rate_hz)


async def press_on(port: int, rate_hz: float) -> None:
    """Press, hear the answer, press again."""
    await ask_on(port, rate_hz, press_of(port))


async def read_on(port: int, rate_hz: float) -> None:
    """Read the machine's state again and again."""
    await ask_on(port, rate_hz, read_of(port))


async def press_anew(port: int, rate_hz: float) -> None:
    """Press once, by a connection of its own."""
    reader, writer = await asyncio.open_connection(HOST, port)
    with contextlib.closing(writer):
        await _answer(reader, writer, press_of(port))
    await asyncio.sleep(1.0 / rate_hz)


async def hold(port: int, _: float) -> None:
    """Begin a press and never end it."""
    reader, writer = await asyncio.open_connection(HOST, port)
    with contextlib.closing(writer):
        writer.write(press_of(port)[:-1])
        await _drain(reader)


KINDS: dict[str, Flooder] = {
    "unheard": press_unheard,
    "presses": press_on,
    "reads": read_on,
    "connections": press_anew,
    "held": hold,
}


async def _drain(reader: asyncio.StreamReader) -> None:
    while await reader.read(65_536):
        pass


async def _answer(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, request: bytes
) -> bool:
    """Ask once, and hear the whole answer; False where the other end hung up."""
    writer.write(request)
    head = await reader.readuntil(b"\r\n\r\n")
    length = head.lower().partition(b"content-length:")[2].partition(b"\r\n")[0]
    await reader.readexactly(int(length or 0))
    return b"connection: close" not in head.lower()


async def keep_on(port: int, rate_hz: float, kind: str) -> None:
    """One connection of a kind, made anew when it was closed."""
    while True:
        with contextlib.suppress(OSError, asyncio.IncompleteReadError):
            await KINDS[kind](port, rate_hz)
        if kind != "connections":
            await asyncio.sleep(AGAIN_S)


async def flood(port: int, connections: int, rate_hz: float, kind: str) -> None:
    """By all of them."""
    each_hz = rate_hz / connections
    await asyncio.gather(*(keep_on(port, each_hz, kind) for _ in range(connections)))


if __name__ == "__main__":
    asyncio.run(flood(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), sys.argv[4]))
