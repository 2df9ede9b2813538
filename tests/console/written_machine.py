"""In a controller's place: a ring, events and a mailbox as it has them, with rows that a test says.

What a console sees of a machine is what lies in the folder; here a thread writes it.
"""

import threading
import time
from pathlib import Path
from typing import Self

import numpy as np

from opensuction.control.compensation import CompensationKind
from opensuction.controller.configuration import Configuration
from opensuction.ipc.liveness import Heartbeat, Process
from opensuction.ipc.mailbox import Mailbox, answer
from opensuction.ipc.ring import EventWriter, RingWriter
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.cycle.transition import STAY
from opensuction.runtime import launch, machine_folder
from opensuction.runtime.loop import ROW_COLUMNS
from opensuction.runtime.machine_folder import ASK, EVENTS, EVENTS_BEFORE, RING, RING_BEFORE
from opensuction.safety import condition_mask
from opensuction.safety.condition import Condition
from opensuction.session.running import basis
from tests.controller.bedside import at_bed
from tests.runtime.identity import ABOUT
from tests.session.running.test_basis import at_bed as at_the_bed

TICK_S = 0.005
TIP = "state.core.governor.watch.tip"
TOLD = {
    "run": "20261123T120000-0badcafe",
    "began_utc_ns": "0",
    "settings": "0f" * 32,
    "version": "0",
    "period_ns": "1000000",
    "state": "",
}
AT_REST = {
    "loop.left_rest": -1.0,
    "inputs.dt_s": 0.001,
    "inputs.readings.head_valid": 1.0,
    "inputs.readings.carriage_valid": 1.0,
    "inputs.readings.cam_valid": 1.0,
    "inputs.readings.vacuum_valid": 1.0,
    "inputs.readings.contact_valid": 1.0,
    "inputs.readings.mouth_clear": 1.0,
    "inputs.readings.monitor.connected": 1.0,
    "inputs.readings.monitor.spo2_percent": 96.0,
    "inputs.readings.monitor.spo2_valid": 1.0,
    "inputs.readings.monitor.heart_rate_per_min": 140.0,
    "inputs.readings.monitor.heart_rate_valid": 1.0,
    "inputs.readings.monitor.airway_pressure_cmh2o": 12.0,
    "inputs.readings.monitor.airway_pressure_valid": 1.0,
    "outputs.phase": float(Phase.PARKED),
    "outputs.cause": float(STAY),
    "outputs.signals.first": -1.0,
    "state.core.procedure.flow.age_ticks": -1.0,
}
"""A row of a machine that is parked; all other columns are 0."""


class WrittenMachine:
    """What a controller would write, every `TICK_S`; buttons that come are answered."""

    def __init__(self, folder: Path, database: str, run: str = TOLD["run"]) -> None:
        loop, _ = at_bed("neonate")
        self.folder = folder
        if not (folder / RING).exists():
            launch.configure(folder, Configuration(loop.controller, loop.heads_mm))
            basis.write(folder, at_the_bed("neonate", CompensationKind.EXACT_INVERSE))
            machine_folder.write(folder, ABOUT._replace(database=database))
        self._mailbox = Mailbox(folder / ASK)
        self._events = EventWriter(folder / EVENTS, folder / EVENTS_BEFORE)
        told = {**TOLD, "run": run, "began_utc_ns": str(time.time_ns() - time.monotonic_ns())}
        self._ring = RingWriter(folder / RING, ROW_COLUMNS, 1000, told, folder / RING_BEFORE)
        self._heartbeat = Heartbeat(folder)
        self._row = np.zeros(len(ROW_COLUMNS))
        self._lock, self._is_over = threading.Lock(), threading.Event()
        self.pressed: list[tuple[str, str]] = []
        """Button and person, in order."""
        self.came_s: list[float] = []
        """When each of them came, monotonic."""
        self.refusal = 0
        """What a start is answered with."""
        self.answers = True
        self._motion, self._tip = loop.controller.plan.motion, loop.controller.limits.tip
        self.set(AT_REST)
        self.place(self._motion.park_mm)
        self.tick()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def set(self, columns: dict[str, float]) -> None:
        """The next rows have these values."""
        with self._lock:
            for name, value in columns.items():
                self._row[ROW_COLUMNS.index(name)] = value

    def place(self, tip_mm: float, unsure_mm: float = 1.0) -> None:
        """The tip is here, give or take; the head where it belongs to that."""
        gain, offset_mm = self._tip.gain, self._tip.offset_mm
        head_mm = self._motion.park_head_mm + (tip_mm - self._motion.park_mm) / gain
        self.set(
            {
                "inputs.readings.head_mm": head_mm,
                "inputs.readings.carriage_mm": head_mm,
                "inputs.readings.mouth_clear": float(tip_mm <= self._motion.park_mm),
                "outputs.demand.reference_mm": tip_mm,
                "state.core.procedure.reference_mm": tip_mm,
                "state.core.procedure.pace.ratio": 1.0,
                f"{TIP}.foremost_mm": (tip_mm + unsure_mm - offset_mm) / gain,
                f"{TIP}.rearmost_mm": (tip_mm - unsure_mm - offset_mm) / gain,
            }
        )

    def raise_alarm(self, *conditions: Condition, first: Condition | None = None) -> None:
        """These alarms sound, and no other; the first of them stands first."""
        mask = float(condition_mask.encode(conditions))
        first = first or (conditions[0] if conditions else None)
        highest = max((one.row.handling.priority for one in conditions), default=0)
        self.set(
            {
                "outputs.signals.present": mask,
                "outputs.signals.first": float(-1 if first is None else first),
                "outputs.signals.priority": float(highest),
                "outputs.signals.audible": float(highest),
            }
        )

    @property
    def number(self) -> int:
        """Tick of the last row."""
        return int(self._row[ROW_COLUMNS.index("inputs.tick")])

    def tick(self) -> None:
        """Take what is asked, and write a row."""
        with self._lock:
            asked, answers = self._mailbox.receive()
            self._row[0] = time.monotonic()
            # Of the row that follows: the last one is not taken for what came of an answer.
            number = self.number + 1
            for one in answers:
                if one.verdict == "pressed":
                    self.pressed.append((one.ask, one.who))
                    self.came_s.append(time.monotonic())
                if self.answers:
                    self._events.write("request", number, **one._asdict())
            setting = self._mailbox.setting
            if setting is not None:
                self._mailbox.setting = None
                self._events.write("request", number, **answer(setting, "set")._asdict())
            if asked.start:
                self._row[ROW_COLUMNS.index("outputs.counters.refusal")] = self.refusal
            self._row[ROW_COLUMNS.index("inputs.tick")] = number
            self._ring.write(self._row)
        self._heartbeat.beat(Process.CONTROL)

    def _run(self) -> None:
        while not self._is_over.wait(TICK_S):
            self.tick()

    def stop(self) -> None:
        """Write no more, as one that has died."""
        self._is_over.set()
        if self._thread.is_alive():
            self._thread.join()
        self._mailbox.close()
        self._events.close()
        self._ring.close()

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if not self._is_over.is_set():
            self.stop()
