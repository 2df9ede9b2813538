"""The controller for an engineer's own loop: readings and requests in, a decision out.

What reaches it is checked and cast here, so that a mistake of the loop is one plain error, and a
fault of the machine is none: readings that are no numbers go to the core, which has its own means
against them. The loop itself, its clock and its drives are not this module's business.
"""

import math
from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any

import numpy as np

from opensuction.controller import controller
from opensuction.controller.configuration import Configuration
from opensuction.controller.real_time_call import INPUT_COLUMNS, OUTPUT_COLUMNS, RealTimeCall
from opensuction.controller.record import Inputs, Outputs, Settings, State
from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import NO_MONITOR, Monitor, Readings, Requests
from opensuction.kernel.record import make_zero
from opensuction.kernel.vocabulary import by_name
from opensuction.procedure.cycle.interlocks import Interlocks
from opensuction.runtime.decision import Decision
from opensuction.safety.condition import Condition
from opensuction.safety.condition_mask import encode
from opensuction.safety.head import head_vote
from opensuction.settings.validation import choose

SHORTEST_TICK_S, LONGEST_TICK_S = 0.0005, 0.002
"""Half and double the tick that everything here was tested with [design]."""
_TICK, _DT, _LATE, _CONDITIONS = (
    INPUT_COLUMNS.index(name) for name in ("tick", "dt_s", "host.overrun", "host.conditions")
)
_ASKED = [
    (i, column)
    for i, column in enumerate(row.layout(Inputs))
    if column.name.startswith(("readings.", "requests."))
]
_OVERRUN = row.Column("overrun", "overrun", bool)
_FIRST, _END = _ASKED[0][0], _ASKED[-1][0] + 1
_KINDS = tuple(column.kind for _, column in _ASKED)
_CONDITION_OF_NAME = by_name(Condition)


def _cast(column: row.Column, value: Any) -> float | bool:
    """A reading or request of another kind than declared, where it stands for one that is."""
    if column.kind is bool:
        if isinstance(value, np.bool_) or (isinstance(value, Integral) and value in (0, 1)):
            return bool(value)
        raise InputError(f"{column.name} is {value!r:.60}: should be True or False")
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{column.name} is {value!r:.60}: should be a number")
    try:
        return float(value)
    except OverflowError:  # of a whole number that no double holds
        return math.inf


def _check_type(name: str, value: object, kind: type) -> None:
    if not isinstance(value, kind):
        raise InputError(f"{name} is {type(value).__name__}: should be {kind.__name__}")


def _values(readings: Readings, requests: Requests) -> list[float | bool]:
    """Readings and requests as the values of a row. Raises InputError."""
    _check_type("readings", readings, Readings)
    _check_type("readings.monitor", readings.monitor, Monitor)
    _check_type("requests", requests, Requests)
    # The monitor is the last of the readings, as in `row.columns`.
    found = [*readings[:-1], *readings.monitor, *requests]
    for i, kind in enumerate(_KINDS):
        if type(found[i]) is not kind:
            found[i] = _cast(_ASKED[i][1], found[i])
    return found


def _mask(conditions: Iterable[str]) -> int:
    """Conditions of the host as a bit mask. Raises InputError for an unknown name."""
    if isinstance(conditions, str):
        raise InputError(f"conditions is {conditions!r:.60}: should be several names")
    found = set()
    for name in conditions:
        found.add(choose(name, _CONDITION_OF_NAME, "condition"))
    return encode(found)


class Controller:
    """The whole controller behind one call a tick; the process around it has clock and drives.

    Construction compiles it, which takes a minute the first time and a second from then on; the
    ticks that follow compile nothing. It is not made for several threads.
    """

    def __init__(
        self,
        settings: Configuration | Settings,
        *,
        catheter_age_s: float = math.nan,
        kept: Interlocks | None = None,
        off_s: float = math.nan,
    ) -> None:
        """settings: as `controller_settings` makes them, or of one's own.

        catheter_age_s: since the catheter's first use, 0 for a new one. Not known (nan) counts as
        over its life, and starts are refused.
        kept: the upkeep of the controller before, from its state: passes, rest and lock-out then
        go on, and so does the catheter's age. off_s: how long no controller ran since; it goes
        with what was kept.
        Raises InputError for settings with a number that is none, and curves that do not fit.
        """
        if isinstance(settings, Settings):
            settings = Configuration(settings)
        elif not isinstance(settings, Configuration):
            raise InputError(f"settings is {type(settings).__name__}: should be a Configuration")
        self.settings = settings
        self._age_s = _number("catheter_age_s", catheter_age_s)
        self._kept, self._off_s = kept, _number("off_s", off_s)
        if kept is not None:
            _check_type("kept", kept, Interlocks)
        if kept is not None and not math.isnan(self._age_s):
            raise InputError("catheter_age_s is in what was kept: give one of the two")
        if kept is not None and not 0.0 <= self._off_s < math.inf:
            raise InputError(f"off_s is {self._off_s:g} s: should be 0 or more, for what was kept")
        if kept is None and not math.isnan(self._off_s):
            raise InputError("off_s goes with kept: without it nothing is known of before")
        chosen = settings.settings
        self._call = RealTimeCall(*settings, self._begin(chosen.parked.head_mm))
        self._inputs, self._outputs = np.zeros(len(INPUT_COLUMNS)), np.zeros(len(OUTPUT_COLUMNS))
        self._is_powered, self._dt_s, self._tick = False, math.nan, 0
        head_vote.first_mm(_PARKED)  # compiled, too

    def _begin(self, head_mm: float) -> State:
        """State at power-up with the head there."""
        chosen = self.settings.settings
        if self._kept is None:
            return controller.start(chosen, head_mm, self._age_s)
        return controller.restart(chosen, head_mm, self._kept, self._off_s)

    @property
    def state(self) -> State:
        """All that it remembers; `kept` of the next controller is ``state.core.upkeep``.

        Setting it is for recovery and tests: before the first tick it takes the place of power-up.
        """
        return self._call.state

    @state.setter
    def state(self, state: State) -> None:
        self._call.state = state
        self._is_powered = True

    def step(
        self,
        readings: Readings,
        requests: Requests,
        dt_s: float,
        *,
        overrun: bool = False,
        conditions: Iterable[str] = (),
    ) -> Decision:
        """One tick. The first one powers the controller up with the head where it is read.

        readings: what the sensors say, each with a flag. Where a flag is false the number may be
        anything, also nan; with a flag that is true nan is a fault of the sensor, as any other.
        dt_s: length of a tick, the same in every call: `SHORTEST_TICK_S` to `LONGEST_TICK_S`.
        overrun: the tick before ended after its deadline. conditions: names of what only the host
        can see, such as ``recorder-lost``: they add alarms, and nothing else.
        Raises InputError for what is of another kind; then nothing has changed.
        """
        found, mask = _values(readings, requests), _mask(conditions)
        late = _cast(_OVERRUN, overrun)
        if dt_s != self._dt_s:
            self._dt_s = self._check_tick(dt_s)
        if not self._is_powered:
            cast = plain_row.unpack(Readings, np.array(found[: len(_READINGS)], dtype=np.float64))
            self.state = self._begin(head_vote.first_mm(cast))
        inputs = self._inputs
        inputs[_FIRST:_END] = found
        inputs[_TICK], inputs[_DT] = self._tick, self._dt_s
        inputs[_LATE], inputs[_CONDITIONS] = late, mask
        self._call.step(inputs, self._outputs)
        self._tick += 1
        return Decision(plain_row.unpack(Outputs, self._outputs))

    def _check_tick(self, dt_s: float) -> float:
        """The length of a tick. Raises InputError for one that cannot be, or that changes."""
        found = _number("dt_s", dt_s)
        if not SHORTEST_TICK_S <= found <= LONGEST_TICK_S:
            raise InputError(
                f"dt_s is {found:g} s: should be {SHORTEST_TICK_S:g} to {LONGEST_TICK_S:g} s"
            )
        if not math.isnan(self._dt_s):
            raise InputError(
                f"dt_s is {found:g} s and was {self._dt_s:g} s before: should be the same in every "
                "tick; say overrun=True after a late one"
            )
        return found


def _number(name: str, value: Any) -> float:
    return float(_cast(row.Column(name, name, float), value))


_READINGS = row.columns(Readings)
_PARKED = make_zero(Readings, head_valid=True, carriage_valid=True, monitor=NO_MONITOR)
