"""A participant of a bus that only listens: time from each SYNC to the nodes' answers.

A process of its own, hardened as the control process is: ``python bus_observer.py FOLDER OUT``.
Told to end it writes to OUT how often SYNC came, and after how long all nodes had answered it.
"""

import json
import signal
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np

from opensuction.host.this_computer import THIS_COMPUTER, hardened
from opensuction.machine.canopen import device_file
from opensuction.machine.canopen.frame_bus import open_bus
from opensuction.machine.canopen.objects import SYNC_ID, tpdo_id

LOOK_S = 50e-6
"""How often it looks for frames: as fine as its times are."""
EDGES_US = (200, 400, 600, 800, 1000, 1200, 1500, 2000, 3000, 4000, 6000, 8000)
"""Between the bins of the histogram; what is longer is counted last."""


def observe(folder: Path, out: Path) -> None:
    """Listen until the process is told to end."""
    ending: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
    device = device_file.find(folder)
    answers = {tpdo_id(node, 1) for node in device.nodes}
    took_s: list[float] = []
    syncs, sync_s, missing = 0, 0.0, set[int]()
    with closing(open_bus(device.bus, THIS_COMPUTER, "observer", folder)) as bus, hardened():
        while not ending:
            time.sleep(LOOK_S)
            now_s = time.monotonic()
            for frame in bus.receive():
                if frame.can_id == SYNC_ID:
                    syncs, sync_s, missing = syncs + 1, now_s, set(answers)
                elif frame.can_id in missing:
                    missing.remove(frame.can_id)
                    if not missing:
                        took_s.append(now_s - sync_s)
    found_us = 1e6 * np.array(took_s)
    counts = np.histogram(found_us, (-np.inf, *EDGES_US, np.inf))[0]
    told = {
        "syncs": syncs,
        "answered": len(took_s),
        "median_us": float(np.median(found_us)),
        "p99_us": float(np.percentile(found_us, 99.0)),
        "most_us": float(found_us.max()),
        "histogram_us": dict(zip([*map(str, EDGES_US), "more"], map(int, counts), strict=True)),
    }
    out.write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    observe(Path(sys.argv[1]), Path(sys.argv[2]))
