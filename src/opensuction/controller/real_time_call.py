"""The controller as a loop calls it against the clock: rows in, rows out, nothing compiled anew.

Settings and state stay on the compiled side, as rows of doubles. A tick takes one row of inputs
and writes one of outputs, so that every type is fixed by construction: a whole number, a flag or a
number of numpy that somebody writes into a row becomes a double there. The state is a row at every
instant: a recording keeps it by copying, and replay compares it bit for bit.
"""

from collections.abc import Callable

import numpy as np

from opensuction.control.compensation import Branches
from opensuction.controller import configuration, controller
from opensuction.controller.configuration import Configuration
from opensuction.controller.record import Inputs, Outputs, Settings, State
from opensuction.kernel.codegen import plain_row, row
from opensuction.kernel.compiled import compiled
from opensuction.kernel.compiler.dispatcher import TypedCall
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array

INPUT_COLUMNS = row.columns(Inputs)
"""Columns of a row of inputs, in order: `Inputs` by dotted path."""
OUTPUT_COLUMNS = row.columns(Outputs)
"""Columns of a row of outputs, in order: `Outputs` by dotted path."""
STATE_COLUMNS = row.columns(State)
"""Columns of a row with the whole state, in order: `State` by dotted path."""

WARM_UP_S = 0.001
"""Tick that a call is warmed up with."""
_INPUT_ROW, _OUTPUT_ROW, _STATE_ROW = (
    (len(columns),) for columns in (INPUT_COLUMNS, OUTPUT_COLUMNS, STATE_COLUMNS)
)
NO_STATES = np.empty((0, *_STATE_ROW))

_read_settings = row.reader(Settings, checked=False)
_read_state = row.reader(State, checked=False)
_write_state = row.writer(State, checked=False)
_read_inputs = row.table_reader(Inputs)
_write_outputs = row.table_writer(Outputs)
_write_states = row.table_writer(State)


@compiled
def play(
    settings: Array,
    heads_mm: Branches | None,
    state: Array,
    inputs: Array,
    outputs: Array,
    states: Array,
) -> None:
    """Ticks of the controller, one for each row of inputs.

    settings, state: a row each; the state is written at the end. inputs, outputs: tables. states:
    a table too, which takes the state after each tick; without rows it takes none.
    """
    chosen, now = _read_settings(settings), _read_state(state)
    for tick in range(inputs.shape[0]):
        now, said = controller.step(chosen, heads_mm, now, _read_inputs(inputs, tick))
        _write_outputs(outputs, tick, said)
        if tick < states.shape[0]:
            _write_states(states, tick, now)
    _write_state(state, now)


def _kind(settings: Array, heads_mm: Branches | None, *_: object) -> bool:  # noqa: ARG001
    return heads_mm is None


def _check(name: str, table: Array, shape: tuple[int, ...], *, written: bool) -> None:
    """Refuse what machine code would read or write past; raises TypeError."""
    is_array = isinstance(table, np.ndarray)
    if not is_array or table.dtype != np.float64 or table.shape != shape:
        found = f"{table.dtype} {table.shape}" if is_array else type(table).__name__
        raise TypeError(f"{name}: {found}, should be float64 {shape}")
    if not (table.flags.c_contiguous and table.flags.aligned):
        raise TypeError(f"{name}: its numbers must lie in memory one after the other")
    if written and not table.flags.writeable:
        raise TypeError(f"{name}: cannot be written to")


class RealTimeCall:
    """A controller whose settings and state stay on the compiled side.

    It is compiled, and has played a tick on a copy of its state, once it is constructed.
    """

    def __init__(self, settings: Settings, heads_mm: Branches | None, state: State) -> None:
        """heads_mm: branches of the compensation's curves; they go with the settings.

        state: as `controller.start` gives it, or as it was read.
        Raises InputError for settings that `configuration.check` refuses.
        """
        configuration.check(Configuration(settings, heads_mm))
        self._state = plain_row.pack(State, state)
        self._settings = plain_row.pack(Settings, settings)
        self._heads_mm = None if heads_mm is None else np.array(heads_mm, np.float64, order="C")
        self._play = TypedCall(play, _kind)
        self._warm_up()

    def configure(self, settings: Settings, heads_mm: Branches | None, state: State) -> None:
        """Go by other settings from the next tick on, in another state.

        Raises InputError for settings that are refused, and for curves where there were none or
        none where there were some: those have other machine code. Then nothing has changed.
        """
        configuration.check(Configuration(settings, heads_mm))
        if (heads_mm is None) != (self._heads_mm is None):
            raise InputError("a compensation by curves is begun and ended with the controller")
        row_of_settings = plain_row.pack(Settings, settings)
        self.state = state
        self._settings = row_of_settings
        if heads_mm is not None:
            self._heads_mm = np.array(heads_mm, np.float64, order="C")

    def _warm_up(self) -> None:
        """A tick on a copy: whatever must be compiled or loaded is."""
        inputs, outputs = np.zeros((1, *_INPUT_ROW)), np.zeros((1, *_OUTPUT_ROW))
        inputs[0, INPUT_COLUMNS.index("dt_s")] = WARM_UP_S
        copy = self._state.copy()
        self._play(self._settings, self._heads_mm, copy, inputs, outputs, NO_STATES)

    @property
    def settings_row(self) -> row.Row:
        """The settings, as a row."""
        return self._settings

    @property
    def heads_mm(self) -> Branches | None:
        """Branches of the compensation's curves, which go with the settings."""
        return self._heads_mm

    @property
    def state_row(self) -> row.Row:
        """The state, by `STATE_COLUMNS`: changed by every tick. To write into it sets the state."""
        return self._state

    @property
    def state(self) -> State:
        """The state as a record."""
        return plain_row.unpack(State, self._state)

    @state.setter
    def state(self, state: State) -> None:
        self._state[:] = plain_row.pack(State, state)

    def step(self, inputs: row.Row, outputs: row.Row) -> None:
        """One tick.

        inputs: a row by `INPUT_COLUMNS`. outputs: a row by `OUTPUT_COLUMNS`, written.
        Raises TypeError for what is no row of doubles of that length; then nothing has changed.
        """
        _check("inputs", inputs, _INPUT_ROW, written=False)
        _check("outputs", outputs, _OUTPUT_ROW, written=True)
        self._play(
            self._settings,
            self._heads_mm,
            self._state,
            inputs[np.newaxis],
            outputs[np.newaxis],
            NO_STATES,
        )

    def bind(self, inputs: row.Row, outputs: row.Row) -> Callable[[], None]:
        """`step` on these two rows and no others, as a loop makes it: they are checked once.

        Where a tick finds its caches empty, to check and look up takes four fifths of a call.
        Raises TypeError as `step` does.
        """
        _check("inputs", inputs, _INPUT_ROW, written=False)
        _check("outputs", outputs, _OUTPUT_ROW, written=True)
        rows = (inputs[np.newaxis], outputs[np.newaxis], NO_STATES)
        play = self._play.find((self._settings, self._heads_mm, self._state, *rows))

        def step() -> None:
            play(self._settings, self._heads_mm, self._state, *rows)

        return step

    def run(self, inputs: Array, outputs: Array, states: Array | None = None) -> None:
        """As many ticks as there are rows of inputs, as fast as they come.

        inputs: a table, columns by `INPUT_COLUMNS`. outputs: one of as many rows, by
        `OUTPUT_COLUMNS`, written. states: likewise by `STATE_COLUMNS`, the state after each tick.
        Raises TypeError for other tables; then nothing has changed.
        """
        ticks = len(inputs)
        _check("inputs", inputs, (ticks, *_INPUT_ROW), written=False)
        _check("outputs", outputs, (ticks, *_OUTPUT_ROW), written=True)
        if states is not None:
            _check("states", states, (ticks, *_STATE_ROW), written=True)
        taken = NO_STATES if states is None else states
        self._play(self._settings, self._heads_mm, self._state, inputs, outputs, taken)
