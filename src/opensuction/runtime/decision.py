"""Decision of the controller in a tick, with the names that people and files use."""

from functools import lru_cache
from typing import NamedTuple

from opensuction.controller.record import Outputs
from opensuction.kernel.interface import Commands
from opensuction.kernel.vocabulary import Phase, name_of
from opensuction.procedure.cycle.lock_out import Refusal
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import decode, decode_trips
from opensuction.safety.handling import Priority


class Alarm(NamedTuple):
    """One alarm that is shown."""

    name: str
    priority: str
    """``low``, ``medium`` or ``high``."""
    sentence: str
    """What is wrong."""
    remedy: str
    """What to do first."""


@lru_cache(maxsize=1024)
def _trips(mask: int) -> tuple[str, ...]:
    return tuple(name_of(condition) for condition in decode_trips(mask))


@lru_cache(maxsize=1024)
def alarms_of(mask: int, escalated: int) -> tuple[Alarm, ...]:
    """The alarms of a mask, in order of their numbers; some of them raised by one priority."""
    found = [Condition(number) for number in decode(mask)]
    return tuple(_alarm(condition, bool(escalated >> condition & 1)) for condition in found)


def _alarm(condition: Condition, is_escalated: bool) -> Alarm:
    sentence, remedy, handling = condition.row
    priority = handling.priority + is_escalated
    shown = name_of(Priority(min(priority, Priority.HIGH)))
    return Alarm(name_of(condition), shown, sentence, remedy)


class Decision(NamedTuple):
    """Decision of the controller in a tick."""

    outputs: Outputs
    """All of it, as numbers."""

    @property
    def commands(self) -> Commands:
        """Commands that the drives follow until the next tick."""
        return self.outputs.commands

    @property
    def phase(self) -> str:
        """Phase of the cycle, such as ``inserting``."""
        return name_of(Phase(self.outputs.phase))

    @property
    def trips(self) -> tuple[str, ...]:
        """Names of the conditions for which the governor holds, withdraws or lets go now."""
        return _trips(self.outputs.verdict.trips)

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Alarms that are shown, those that have ended and wait for a reset among them."""
        signals = self.outputs.signals
        return alarms_of(signals.present | signals.latched, signals.escalated)

    @property
    def refusal(self) -> str | None:
        """Reason why the last start was refused; None where none was."""
        refusal = Refusal(self.outputs.counters.refusal)
        return None if refusal == Refusal.NONE else name_of(refusal)
