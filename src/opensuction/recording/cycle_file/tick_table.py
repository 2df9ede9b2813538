"""Tables of a controller in a recording: a row for each tick, and each state that was set.

The columns are the same for a simulation and a machine. A tick's row has all inputs, all outputs,
and the whole state after the tick.
"""

from opensuction.controller.record import Inputs, Outputs, State
from opensuction.kernel.codegen import row
from opensuction.recording.cycle_file.row_schema import SchemaColumn

TICKS = "/tick"
"""Topic of the ticks; a tick that is missing was not made, or its row was lost."""
STARTS = "/start"
"""Topic of states that were set from outside; each belongs before the tick that it names."""
INPUTS, OUTPUTS, STATE = "inputs", "outputs", "state"
"""How the names of a tick's columns begin."""


def prefixed(prefix: str, record_type: type) -> tuple[SchemaColumn, ...]:
    """Columns of a record, their names behind a prefix."""
    return tuple(SchemaColumn(f"{prefix}.{one.name}", one.kind) for one in row.layout(record_type))


TICK_COLUMNS = (
    *prefixed(INPUTS, Inputs),
    *prefixed(OUTPUTS, Outputs),
    *prefixed(STATE, State),
)
START_COLUMNS = (SchemaColumn("tick", int), *prefixed(STATE, State))

TABLES = {TICKS: TICK_COLUMNS, STARTS: START_COLUMNS}
"""Columns of each topic, as a writer takes them."""

INPUT_PART = slice(0, len(row.columns(Inputs)))
OUTPUT_PART = slice(INPUT_PART.stop, INPUT_PART.stop + len(row.columns(Outputs)))
STATE_PART = slice(OUTPUT_PART.stop, len(TICK_COLUMNS))
"""Where a tick's row has them."""
