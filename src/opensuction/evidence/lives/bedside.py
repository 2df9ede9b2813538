"""The bedside of a simulated machine: its display, and the buttons as a person presses them."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from opensuction.host.host import Host, Steps, after
from opensuction.ipc.mailbox import Sender
from opensuction.ipc.ring import EventReader, FollowedRing, ProcessEvent
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import STOP
from opensuction.kernel.vocabulary import CYCLE, RESTING, Phase
from opensuction.procedure.cycle.interlocks import LIFE_S
from opensuction.runtime import machine_folder
from opensuction.runtime.loop import ROW_COLUMNS

NURSE, VISITOR = "nurse", "visitor"
LOOK_S = 0.1
"""How often people look at the machine."""
PRESS_S = 0.06
"""Between two buttons of one person."""
START = "start"
PRESSED = "pressed"
"""Verdict on a button that was carried out."""
PATIENCE_S = 3.0
"""After it a person presses again what was not answered."""
_PHASE, _TICK = (ROW_COLUMNS.index(name) for name in ("outputs.phase", "inputs.tick"))
_AGE = ROW_COLUMNS.index("state.core.upkeep.catheter_age_s")
_REST = ROW_COLUMNS.index("outputs.counters.rest_left_s")


class Situation(NamedTuple):
    """State of a machine as a person sees it."""

    phase: Phase
    tick: int
    is_rested: bool
    """The patient has rested since the last cycle."""
    is_worn: bool
    """The catheter has been used for its life, or nobody knows for how long."""


class Display:
    """State of a machine as its controller shows it."""

    def __init__(self, folder: Path) -> None:
        self._ring = FollowedRing(folder / machine_folder.RING, lambda found: found == ROW_COLUMNS)
        self._shown_by = -1

    def phase_number(self, pid: int) -> int:
        """Number of the phase now, before a step of a controller; -1 where none shows any.

        pid: of the controller's process.
        """
        if pid != self._shown_by and self._ring.look():
            self._shown_by = pid
        reader = self._ring.reader
        return -1 if reader is None or reader.newest() == 0 else int(reader.peek(_PHASE))

    def look(self) -> Situation | None:
        """State of the machine now; None where no controller has shown any."""
        self._ring.look()
        newest = None if self._ring.reader is None else self._ring.reader.snapshot()
        if newest is None:
            return None
        row = newest[1]
        return Situation(
            Phase(int(row[_PHASE])), int(row[_TICK]), row[_REST] == 0.0, not row[_AGE] < LIFE_S
        )


class Bedside(Display):
    """A machine's display and buttons, before one person."""

    def __init__(self, folder: Path, host: Host, who: str) -> None:
        super().__init__(folder)
        self._folder, self._host, self._who, self._asked = folder, host, who, 0
        self.is_impatient = False
        self.asked_ns: dict[str, int] = {}
        """When a request was sent, by its key."""
        self.unanswered: Callable[[int], None] = lambda _: None
        """Told when a request was sent that nobody has answered by now."""
        self._heard: list[ProcessEvent] = []
        """Events since the last button was pressed, until it was answered."""

    def press(self, button: str) -> Steps[str]:
        """Press a button; the verdict, empty where there is none within `PATIENCE_S`."""
        self._asked += 1
        key, clock = f"{self._who}-{self._asked}", self._host.clock
        try:
            events = EventReader(self._folder / machine_folder.EVENTS)
            events.read()
            self._heard.clear()
            sender = Sender(self._folder / machine_folder.ASK, self._who, 0.0, self._host)
            sent_ns = clock.monotonic_ns()
            for name in (key, f"{key}-again")[: 1 + self.is_impatient]:
                self.asked_ns[name] = sent_ns
                sender.ask(button, name, "2025-06-15T15:06:40Z")
        except InputError:
            return ""
        ends_ns = after(clock, PATIENCE_S)
        while clock.monotonic_ns() < ends_ns:
            yield after(clock, PRESS_S)
            self._heard += events.read()[0]
            for one in self._heard:
                if one.fields.get("key") == key:
                    return str(one.fields["verdict"])
        self.unanswered(sent_ns)
        return ""

    def has_started_since(self, button: str) -> bool:
        """True where somebody has started a cycle after this button, which was pressed last."""
        pressed = [
            str(one.fields["ask"])
            for one in self._heard
            if one.fields["kind"] == "request" and one.fields["verdict"] == PRESSED
        ]
        return button in pressed and START in pressed[pressed.index(button) :]


class People:
    """People at the bed of a machine, and what they have done and seen."""

    def __init__(self, folder: Path) -> None:
        self.problems: list[str] = []
        """What they have seen that must not be."""
        self.has_cycled = False
        """The nurse's cycles are over."""
        self._cycles = 1
        self._begins: Callable[[int], None] = lambda _: None
        self.unanswered: Callable[[int], None] = lambda _: None
        """See `Bedside.unanswered`."""
        self._folder = folder
        self._bedsides: list[Bedside] = []
        self._was_impatient = False

    @property
    def asked_ns(self) -> dict[str, int]:
        """Instant at which each request was sent, by its key."""
        return {key: at_ns for one in self._bedsides for key, at_ns in one.asked_ns.items()}

    def start_cycles(self, count: int, begins: Callable[[int], None]) -> None:
        """Have the nurse start so many cycles.

        begins: told of each but the first, by its number from 1 on, as the patient has rested.
        """
        self._cycles, self._begins = count, begins

    def hurry(self) -> None:
        """From now on they press twice."""
        self._was_impatient = True
        for one in self._bedsides:
            one.is_impatient = True

    def _bedside(self, host: Host, who: str) -> Bedside:
        made = Bedside(self._folder, host, who)
        made.is_impatient = self._was_impatient
        made.unanswered = self._leave_unanswered
        self._bedsides.append(made)
        return made

    def _leave_unanswered(self, sent_ns: int) -> None:
        self.unanswered(sent_ns)

    def nurse(self, host: Host) -> Steps[None]:
        """Start the cycles, and bring the machine back to its park position for ever.

        A catheter that was used for too long is changed first.
        """
        bed, number, has_begun = self._bedside(host, NURSE), 0, False
        while True:
            yield after(host.clock, LOOK_S)
            seen = bed.look()
            if seen is None:
                continue
            has_begun = has_begun or seen.phase in CYCLE
            is_last = number == self._cycles - 1
            if has_begun and not is_last and seen.phase == Phase.PARKED and seen.is_rested:
                number, has_begun = number + 1, False
                self._begins(number)
            self.has_cycled = has_begun and is_last and seen.phase in RESTING
            if seen.phase == Phase.HALTED:
                yield after(host.clock, PATIENCE_S)
                yield from bed.press("reset")
            for button in _find_buttons(seen, may_start=not has_begun):
                yield from bed.press(button)

    def visitor(self, host: Host) -> Steps[None]:
        """Press STOP until it is answered: then nothing goes in any more."""
        bed = self._bedside(host, f"visitor at {host.clock.monotonic_ns()}")
        while not (verdict := (yield from bed.press(STOP))):
            yield after(host.clock, LOOK_S)
        seen = bed.look()
        goes_on = seen is not None and seen.phase in CYCLE
        if seen is not None and goes_on and verdict == PRESSED and not bed.has_started_since(STOP):
            self.problems.append(f"a STOP was answered, and the machine is {seen.phase.name}")


def _find_buttons(seen: Situation, may_start: bool) -> tuple[str, ...]:
    """Buttons that bring a machine back, or begin a cycle."""
    if seen.phase == Phase.OUT_OF_SERVICE:
        return ("changed", "return_to_service")
    if seen.phase == Phase.PARKED and may_start:
        if seen.is_worn:
            return ("service",)
        if seen.is_rested:
            # The drives have acted alone until there was a controller, and show it until then.
            return ("reset", "assessed", "oxygen_skipped", START)
    return ()
