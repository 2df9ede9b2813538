"""A flood of presses, as a process: ``python -m tests.console.load.flood PORT CONNECTIONS RATE``.

So many connections, which together press *Stop* so often a second, whether they are answered or
not: what the console does not read waits in the sockets. It goes on until it is killed.
"""

import asyncio
import contextlib
import sys

HOST = "127.0.0.1"
BODY = b'{"ask":"abort","key":"the-same-key-each-time"}'
PENDING_BYTES = 65_536


async def press(port: int, rate_hz: float) -> None:
    """By one connection, which is made anew when it was closed."""
    said = (
        f"POST /api/v1/requests HTTP/1.1\r\nHost: {HOST}:{port}\r\nContent-Length: {len(BODY)}\r\n"
    )
    request = f"{said}Content-Type: application/json\r\n\r\n".encode() + BODY
    while True:
        with contextlib.suppress(OSError):
            reader, writer = await asyncio.open_connection(HOST, port)
            listening = asyncio.create_task(_drain(reader))
            while not writer.is_closing() and not listening.done():
                if writer.transport.get_write_buffer_size() < PENDING_BYTES:
                    writer.write(request)
                await asyncio.sleep(1.0 / rate_hz)
            writer.close()
        await asyncio.sleep(0.05)


async def _drain(reader: asyncio.StreamReader) -> None:
    while await reader.read(65_536):
        pass


async def flood(port: int, connections: int, rate_hz: float) -> None:
    """By all of them."""
    await asyncio.gather(*(press(port, rate_hz / connections) for _ in range(connections)))


if __name__ == "__main__":
    asyncio.run(flood(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])))
