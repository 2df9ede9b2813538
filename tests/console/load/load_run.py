"""Load of a console with many pages: processor time, lateness of the loop, times of stops."""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import NamedTuple
from uuid import uuid4

import httpx
import numpy as np

from opensuction.ipc.ring import RingReader
from opensuction.kernel.record import Array
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import RING
from tests.console.load.console_machine import ConsoleMachine, cpu_s, sleep_until
from tests.console.load.pages import Came

CHANNELS = (
    "inputs.readings.carriage_mm",
    "outputs.demand.reference_mm",
    "tip.high_mm",
    "tip.low_mm",
    "state.core.governor.watch.speed_mm_per_s",
    "outputs.commands.insertion_v",
    "inputs.readings.line_vacuum_mmhg",
    "inputs.readings.insertion_current_a",
)
"""Eight, as an engineer looks at an insertion."""
SETTLES_S = 2.0
"""After pages were opened, before anything is counted."""
PRESSED_S = 2.0
"""Within this time a press is in the ring, or it is lost."""
_TIME, _LATE, _COMPUTED, _SKIPPED, _ABORT, _TICK = (
    ROW_COLUMNS.index(name)
    for name in (
        "loop.time_s",
        "loop.late_s",
        "loop.computed_s",
        "loop.skipped",
        "inputs.requests.abort",
        "inputs.tick",
    )
)


class Stretch(NamedTuple):
    """The control loop and the console over some seconds."""

    seconds: float
    ticks: int
    missed: int
    late_us_p99: float
    console_cores: float
    """Processor time over time: 1 is one core."""


@contextmanager
def pages(machine: ConsoleMachine, live: int, signals: int) -> Iterator[Callable[[], Came]]:
    """Pages without a browser, at the lowest priority: elsewhere they run on other computers.

    Gives what ends them and says what came.
    """
    counts = (str(live), str(signals), ",".join(CHANNELS))
    command = ["nice", "-n", "19", sys.executable, "-m", "tests.console.load.pages", machine.url]
    process = subprocess.Popen(
        [*command, machine.cookie("observer"), *counts],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        assert process.stdout.readline(), "no pages"
        yield lambda: Came(**json.loads(process.communicate(timeout=30.0)[0]))
    finally:
        process.kill()
        process.communicate()


def stretch(machine: ConsoleMachine, seconds: float) -> Stretch:
    """What goes on for so long."""
    ring = RingReader(machine.room.folder / RING)
    ring.next = ring.newest() + 1
    rows: list[Array] = []
    begun_s, begun_cpu_s = time.monotonic(), cpu_s(machine.console.pid)
    while time.monotonic() < begun_s + seconds:
        sleep_until(min(time.monotonic() + 0.5, begun_s + seconds))
        rows.append(ring.read().rows)
    lasted_s = time.monotonic() - begun_s
    used_s = cpu_s(machine.console.pid) - begun_cpu_s
    every = np.concatenate(rows)
    return Stretch(
        seconds=lasted_s,
        ticks=len(every),
        missed=int(every[:, _SKIPPED].sum()),
        late_us_p99=float(1e6 * np.quantile(every[:, _LATE], 0.99)),
        console_cores=used_s / lasted_s,
    )


class Stops(NamedTuple):
    """From the beginning of the request to the end of the tick that had it."""

    presses: int
    lost: int
    p50_ms: float
    p99_ms: float
    most_ms: float


def stops(machine: ConsoleMachine, count: int, pause_s: float = 0.12) -> Stops:
    """Stop a machine that is parked again and again, as a page does."""
    ring = RingReader(machine.room.folder / RING)
    took_s: list[float] = []
    with httpx.Client(base_url=machine.url, headers={"Origin": machine.url}) as client:
        for _ in range(count):
            ring.next = ring.newest() + 1
            pressed_s = time.monotonic()
            body = {"ask": "abort", "key": uuid4().hex}
            answer = client.post("/api/v1/requests", json=body)
            assert answer.status_code == 200, answer.text
            ended_s = _end_of_tick(ring, pressed_s)
            if ended_s is not None:
                took_s.append(ended_s - pressed_s)
            time.sleep(pause_s)
    p50, p99, most = np.quantile(took_s, (0.5, 0.99, 1.0)) * 1e3
    return Stops(count, count - len(took_s), float(p50), float(p99), float(most))


def _end_of_tick(ring: RingReader, pressed_s: float) -> float | None:
    """When the commands were out of the tick in which the button was down."""
    while time.monotonic() < pressed_s + PRESSED_S:
        rows = ring.read().rows
        found = np.flatnonzero(rows[:, _ABORT] == 1.0)
        if len(found):
            row = rows[found[0]]
            after = rows[found[0] + 1] if found[0] + 1 < len(rows) else _next(ring)
            return float(row[_TIME] + row[_LATE] + after[_COMPUTED])
        time.sleep(0.001)
    return None


def _next(ring: RingReader) -> Array:
    """The row that comes next: it says how long the tick before it took."""
    while True:
        rows = ring.read(1).rows
        if len(rows):
            row: Array = rows[0]
            return row
        time.sleep(0.0005)


Opening = Callable[[], AbstractContextManager[object]]
"""What opens pages, for as long as they are looked at."""


def alternate(
    machine: ConsoleMachine, kinds: dict[str, Opening], rounds: int, seconds: float
) -> dict[str, list[Stretch]]:
    """The same stretch with each kind of pages, in turn: what else the computer does is shared."""
    found: dict[str, list[Stretch]] = {name: [] for name in kinds}
    for turn in range(rounds):
        names = list(kinds) if turn % 2 == 0 else list(reversed(kinds))
        for name in names:
            with kinds[name]():
                time.sleep(SETTLES_S)
                found[name].append(stretch(machine, seconds))
    return found


NOBODY: Opening = nullcontext


def write(folder: Path, figures: object) -> None:
    """For the evidence."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(figures, indent=1)
    (folder / "console-load.json").write_text(f"{text}\n", encoding="utf-8")
