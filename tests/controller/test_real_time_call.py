import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller import controller, real_time_call, setup
from opensuction.controller.calibration import Feedforward, assume_nominal
from opensuction.controller.machine_profile import BENCH
from opensuction.controller.real_time_call import (
    INPUT_COLUMNS,
    OUTPUT_COLUMNS,
    STATE_COLUMNS,
    RealTimeCall,
)
from opensuction.controller.record import Settings
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.codegen.row import Row
from opensuction.kernel.compiler.dispatcher import CoreFunction
from opensuction.kernel.errors import InputError
from opensuction.kernel.record import Array
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER

CALIBRATION = assume_nominal(PUBLISHED, Feedforward(velocity_v_s_per_mm=1.28, friction_v=0.5))
TICKS = 50


def settings(kind: CompensationKind = CompensationKind.PREVIEW) -> Settings:
    return setup.settings(BENCH, PAPER, kind, CALIBRATION, by_contact=False, site=BENCH_SITE)


def call(kind: CompensationKind = CompensationKind.PREVIEW) -> RealTimeCall:
    chosen = settings(kind)
    state = controller.start(chosen, chosen.parked.head_mm, 0.0)
    return RealTimeCall(chosen, setup.branches(kind, CALIBRATION), state)


def at(name: str) -> int:
    return INPUT_COLUMNS.index(name)


def parked(head_mm: float, ticks: int = TICKS) -> Array:
    """What a sound machine at rest reads, a start asked for in the third tick."""
    table = np.zeros((ticks, len(INPUT_COLUMNS)))
    table[:, at("tick")] = np.arange(ticks)
    table[:, at("dt_s")] = 0.001
    for name in ("readings.head_mm", "readings.carriage_mm"):
        table[:, at(name)] = head_mm
    for flag in ("head", "carriage", "cam", "vacuum", "contact"):
        table[:, at(f"readings.{flag}_valid")] = 1.0
    table[2, at("requests.start")] = 1.0
    return table


def outputs(ticks: int = TICKS) -> Array:
    return np.full((ticks, len(OUTPUT_COLUMNS)), -7.0)


def states(ticks: int = TICKS) -> Array:
    return np.full((ticks, len(STATE_COLUMNS)), -7.0)


def play(chosen: RealTimeCall, inputs: Array) -> tuple[Array, Array]:
    """Outputs and states of some ticks, one call each."""
    said, kept = outputs(len(inputs)), states(len(inputs))
    for tick, row in enumerate(inputs):
        chosen.step(row, said[tick])
        kept[tick] = chosen.state_row
    return said, kept


def test_columns_have_one_name_each_and_hold_the_numbers_of_tuples() -> None:
    for columns in (INPUT_COLUMNS, OUTPUT_COLUMNS, STATE_COLUMNS):
        assert len(set(columns)) == len(columns)
    assert {"tick", "dt_s", "readings.head_mm", "requests.abort", "host.overrun"} <= set(
        INPUT_COLUMNS
    )
    assert {"commands.insertion_v", "verdict.trips", "signals.first"} <= set(OUTPUT_COLUMNS)
    assert {"core.procedure.phase", "compensation.plays_mm.15", "alarms.clocks.held_s.0"} <= set(
        STATE_COLUMNS
    )


def test_a_start_that_is_asked_for_begins_the_pre_use_test() -> None:
    chosen = call()
    said, _ = play(chosen, parked(settings().parked.head_mm))
    phase = said[:, OUTPUT_COLUMNS.index("phase")]
    assert phase[0] == Phase.PARKED
    assert phase[-1] == Phase.CHECKING == chosen.state.core.procedure.phase


def test_constructing_it_leaves_the_state_as_it_was_given() -> None:
    chosen = settings()
    state = controller.start(chosen, chosen.parked.head_mm, 1.5)
    assert RealTimeCall(chosen, None, state).state == state


@pytest.mark.parametrize("kind", [CompensationKind.PREVIEW, CompensationKind.LOOKUP_TABLE])
def test_many_ticks_at_once_equal_the_same_ticks_one_by_one(kind: CompensationKind) -> None:
    inputs = parked(settings(kind).parked.head_mm)
    one_by_one = play(call(kind), inputs)
    said, kept, chosen = outputs(), states(), call(kind)
    chosen.run(inputs, said, kept)
    assert said.tobytes() == one_by_one[0].tobytes()
    assert kept.tobytes() == one_by_one[1].tobytes()
    assert chosen.state_row.tobytes() == kept[-1].tobytes()


def test_rows_that_are_bound_are_played_as_any_others() -> None:
    inputs = parked(settings().parked.head_mm)
    whole, kept = play(call(), inputs)
    chosen, read, said = call(), np.zeros(len(INPUT_COLUMNS)), np.zeros(len(OUTPUT_COLUMNS))
    step = chosen.bind(read, said)
    for tick, row in enumerate(inputs):
        read[:] = row
        step()
        assert said.tobytes() == whole[tick].tobytes()
        assert chosen.state_row.tobytes() == kept[tick].tobytes()
        chosen.state = chosen.state  # what is set in between is what it goes on from
    for wrong in (np.zeros(3), read[::-1]):
        with pytest.raises(TypeError, match="inputs"):
            chosen.bind(wrong, said)


def test_a_state_that_is_read_and_set_again_goes_on_as_before() -> None:
    inputs = parked(settings().parked.head_mm)
    whole, _ = play(call(), inputs)
    first, second = call(), call()
    play(first, inputs[:20])
    second.state = first.state
    assert second.state_row.tobytes() == first.state_row.tobytes()
    rest, _ = play(second, inputs[20:])
    assert rest.tobytes() == whole[20:].tobytes()


def test_a_state_row_that_is_kept_is_a_state_that_can_be_set() -> None:
    inputs = parked(settings().parked.head_mm)
    whole, kept = play(call(), inputs)
    chosen = call()
    chosen.state_row[:] = kept[19]
    rest, _ = play(chosen, inputs[20:])
    assert rest.tobytes() == whole[20:].tobytes()


@pytest.mark.skipif(not isinstance(real_time_call.play, CoreFunction), reason="nothing is compiled")
def test_nothing_is_compiled_anew_whatever_is_written_into_the_rows() -> None:
    chosen, said = call(), outputs(1)[0]
    play(chosen, parked(settings().parked.head_mm))
    before = len(real_time_call.play.overloads)  # type: ignore[attr-defined]
    row = parked(settings().parked.head_mm)[0]
    for value in (3, True, np.int64(3), np.float32(3.0), np.bool_(True), np.uint8(3)):
        row[at("readings.head_mm")] = row[at("readings.contact_closed")] = value
        row[at("tick")] = row[at("host.conditions")] = value
        chosen.step(row, said)
    state = chosen.state
    core = state.core._replace(cam_rad=1, tripped=np.bool_(True), held=np.int64(3))  # type: ignore[arg-type]
    chosen.state = state._replace(core=core)
    chosen.step(row, said)
    limits = settings().limits._replace(in_airway_s=30)
    RealTimeCall(settings()._replace(limits=limits), None, state._replace(core=core)).step(
        row, said
    )
    assert len(real_time_call.play.overloads) == before  # type: ignore[attr-defined]


BAD_ROWS = {
    "too short": np.zeros(len(INPUT_COLUMNS) - 1),
    "too long": np.zeros(len(INPUT_COLUMNS) + 1),
    "single": np.zeros(len(INPUT_COLUMNS), dtype=np.float32),
    "swapped": np.zeros(len(INPUT_COLUMNS), dtype=">f8"),
    "strided": np.zeros(2 * len(INPUT_COLUMNS))[::2],
    "table": np.zeros((1, len(INPUT_COLUMNS))),
    "crooked": np.zeros(8 * len(INPUT_COLUMNS) + 8, np.uint8)[1 : 8 * len(INPUT_COLUMNS) + 1].view(
        np.float64
    ),
    "list": [0.0] * len(INPUT_COLUMNS),
}


@pytest.mark.parametrize("name", BAD_ROWS)
def test_what_is_no_row_of_inputs_is_refused_and_changes_nothing(name: str) -> None:
    chosen, said = call(), outputs(1)[0]
    before = chosen.state_row.copy()
    with pytest.raises(TypeError, match="inputs"):
        chosen.step(BAD_ROWS[name], said)  # type: ignore[arg-type]
    assert chosen.state_row.tobytes() == before.tobytes()
    assert np.all(said == -7.0)


def test_outputs_and_states_that_do_not_fit_are_refused() -> None:
    chosen, inputs = call(), parked(settings().parked.head_mm)
    before = chosen.state_row.copy()
    fixed: Row = outputs(1)[0]
    fixed.flags.writeable = False
    with pytest.raises(TypeError, match="outputs: cannot be written to"):
        chosen.step(inputs[0], fixed)
    with pytest.raises(TypeError, match=r"outputs: float64 \(49, 47\), should be .*\(50, 47\)"):
        chosen.run(inputs, outputs(TICKS - 1))
    with pytest.raises(TypeError, match="states"):
        chosen.run(inputs, outputs(), states(TICKS - 1))
    assert chosen.state_row.tobytes() == before.tobytes()


def test_inputs_that_cannot_be_written_to_are_as_good_as_others() -> None:
    inputs = parked(settings().parked.head_mm)
    said, fixed = outputs(), np.frombuffer(inputs.tobytes()).reshape(inputs.shape)
    call().run(fixed, said)
    assert said.tobytes() == play(call(), inputs)[0].tobytes()


def test_no_ticks_change_nothing() -> None:
    chosen = call()
    before = chosen.state_row.copy()
    chosen.run(np.zeros((0, len(INPUT_COLUMNS))), outputs(0), states(0))
    assert chosen.state_row.tobytes() == before.tobytes()


def test_curves_may_lie_in_memory_in_any_order() -> None:
    kind = CompensationKind.LOOKUP_TABLE
    chosen, heads_mm = settings(kind), setup.branches(kind, CALIBRATION)
    assert heads_mm is not None
    state = controller.start(chosen, chosen.parked.head_mm, 0.0)
    turned = RealTimeCall(chosen, np.asfortranarray(heads_mm), state)
    inputs = parked(chosen.parked.head_mm)
    assert play(turned, inputs)[0].tobytes() == play(call(kind), inputs)[0].tobytes()


def test_curves_that_are_missing_are_refused_at_once() -> None:
    chosen = settings(CompensationKind.LOOKUP_TABLE)
    state = controller.start(chosen, chosen.parked.head_mm, 0.0)
    with pytest.raises(InputError, match="needs curves"):
        RealTimeCall(chosen, None, state)
