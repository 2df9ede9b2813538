import itertools

import numpy as np
import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.kernel.compiler.dispatcher import CoreFunction
from opensuction.kernel.interface import ABORT, NO_REQUESTS, START
from opensuction.kernel.vocabulary import Phase
from opensuction.procedure.planning.protocol import PAPER
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.trace import Columns
from opensuction.twin.sensor import sensor

GOLDEN_COLUMNS = [
    "time_s",
    "phase",
    "cause",
    "check_item",
    "check_failed",
    "readings.head_mm",
    "readings.head_valid",
    "readings.carriage_mm",
    "readings.carriage_valid",
    "readings.cam_rad",
    "readings.cam_valid",
    "readings.line_vacuum_mmhg",
    "readings.vacuum_valid",
    "readings.contact_closed",
    "readings.contact_valid",
    "readings.mouth_clear",
    "readings.insertion_current_a",
    "readings.monitor.connected",
    "readings.monitor.spo2_percent",
    "readings.monitor.spo2_valid",
    "readings.monitor.heart_rate_per_min",
    "readings.monitor.heart_rate_valid",
    "readings.monitor.airway_pressure_cmh2o",
    "readings.monitor.airway_pressure_valid",
    "demand.reference_mm",
    "demand.reference_mm_per_s",
    "demand.direction",
    "demand.starts_in_s",
    "demand.homing",
    "demand.jog_mm",
    "demand.insertion_on",
    "demand.valve_open",
    "demand.valve_on",
    "demand.pump_on",
    "demand.vacuum_mmhg",
    "verdict.reaction",
    "verdict.trips",
    "verdict.patient",
    "verdict.deepest_mm",
    "verdict.insertion_on",
    "verdict.turned",
    "verdict.valve_on",
    "commands.head_mm",
    "commands.insertion_v",
    "commands.insertion_on",
    "commands.cam_rad",
    "commands.valve_v",
    "commands.valve_on",
    "commands.pump_on",
    "commands.vacuum_mmhg",
    "signals.priority",
    "signals.audible",
    "signals.first",
    "signals.present",
    "signals.latched",
    "signals.acknowledged",
    "signals.escalated",
    "signals.pause_left_s",
    "signals.reminder",
    "truth.head_mm",
    "truth.tip_mm",
    "truth.laser_mm",
    "truth.contact_n",
    "truth.valve_open_ratio",
    "truth.tip_vacuum_mmhg",
    "truth.gas_ml_per_s",
    "truth.secretion_removed_ml",
    "truth.bore_ml",
    "truth.canister_ml",
    "truth.line_vacuum_mmhg",
    "truth.airway_pressure_cmh2o",
    "truth.lung_volume_ml",
    "truth.lung_volume_loss_ml",
    "truth.spo2_percent",
    "truth.heart_rate_per_min",
    "truth.piece_mm",
    "truth.carina_shift_mm",
    "truth.muscle_cmh2o",
    "truth.relaxed_pressure_cmh2o",
    "truth.relaxed_loss_ml",
    "annunciator.said",
    "annunciator.watchdog_fired",
    "annunciator.reserve_used",
    "annunciator.message_late",
    "counters.passes",
    "counters.rest_left_s",
    "counters.resets",
    "counters.locked_out",
    "counters.preoxygenation",
    "counters.refusal",
    "counters.late_share",
]
"""Names that recordings, reports and plots rely on: a change here breaks what people stored."""


def ready(seed: int = 1, run: int = 2) -> tuple[Loop, LoopState]:
    rig = rigs.rig("bench", seed)
    calibration = rigs.uncalibrated(rig.profile)
    return rigs.assemble(rig, PAPER, CompensationKind.EXACT_INVERSE, calibration, run)


def cycle(seed: int = 1, run: int = 2, *, exact: bool = False) -> tuple[LoopState, Columns]:
    loop, start = ready(seed, run)
    if exact:
        sensors = sensor.exact_sensors(loop.machine.sensors)
        loop = loop._replace(machine=loop.machine._replace(sensors=sensors))
    return trace.record(loop, start, START, 60.0)


def same(one: Columns, other: Columns) -> bool:
    return all(np.array_equal(one[name], other[name]) for name in COLUMNS)


def test_column_names_are_stable() -> None:
    assert list(COLUMNS) == GOLDEN_COLUMNS


def test_same_seed_same_trace() -> None:
    assert same(cycle()[1], cycle()[1])


def test_another_run_has_other_noise_on_the_same_machine() -> None:
    noisy = ("truth.laser_mm", "readings.line_vacuum_mmhg", "readings.insertion_current_a")
    one, other = cycle(run=2)[1], cycle(run=3)[1]
    for name in noisy:
        assert not np.array_equal(one[name][:1000], other[name][:1000]), name
    one, other = cycle(run=2, exact=True)[1], cycle(run=3, exact=True)[1]
    assert not np.array_equal(one["truth.laser_mm"], other["truth.laser_mm"])
    # The controller never reads the laser, so with exact sensors nothing else differs once the
    # first messages, which the noisy ones had sent before, are over.
    for name in COLUMNS:
        if name != "truth.laser_mm":
            assert np.array_equal(one[name][1:], other[name][1:]), name


def test_another_seed_is_another_machine() -> None:
    one, other = cycle(seed=1)[1], cycle(seed=2)[1]
    least = min(one["time_s"].size, other["time_s"].size)
    assert not np.array_equal(one["truth.tip_mm"][:least], other["truth.tip_mm"][:least])


@pytest.mark.parametrize(
    "pieces",
    [
        # To hand a state over and take it back costs as much as hundreds of ticks.
        pytest.param((1,), marks=pytest.mark.soak),
        pytest.param((7,), marks=pytest.mark.soak),
        (1, 1, 7, 100),
        (1000,),
    ],
)
def test_run_in_pieces_equals_run_at_once(pieces: tuple[int, ...]) -> None:
    loop, state = ready()
    ticks = 12_000
    at_once = trace.rows(ticks * DT_S)
    ended, done = closed_loop.run(loop, state, START, at_once)
    assert done == ticks
    in_pieces = trace.rows(ticks * DT_S)
    requests, lengths, done = START, itertools.cycle(pieces), 0
    while done < ticks:
        piece = in_pieces[done : done + next(lengths)]
        state, _ = closed_loop.run(loop, state, requests, piece)
        requests, done = NO_REQUESTS, done + len(piece)
    assert np.array_equal(at_once, in_pieces)
    assert state.tick == ended.tick
    assert str(state) == str(ended)


def test_it_stops_when_the_machine_rests_again() -> None:
    loop, start = ready()
    table = trace.rows(60.0)
    state, ticks = closed_loop.run(loop, start, START, table)
    assert ticks < len(table)
    assert table[ticks - 1, COLUMNS.index("phase")] == Phase.PARKED
    assert table[ticks - 2, COLUMNS.index("phase")] == Phase.CLOSING
    assert np.all(table[ticks:] == 0.0)
    assert state.tick == ticks


def test_it_stops_when_the_trace_is_full() -> None:
    loop, start = ready()
    table = trace.rows(0.5)
    state, ticks = closed_loop.run(loop, start, START, table)
    assert ticks == len(table) == 500
    assert state.tick == 500
    assert table[-1, 0] == pytest.approx(0.499)


def test_a_machine_at_rest_runs_on_until_the_trace_is_full() -> None:
    loop, start = ready()
    state, columns = trace.record(loop, start, NO_REQUESTS, 2.0)
    assert state.tick == 2000
    assert np.all(columns["phase"] == Phase.PARKED)
    assert np.ptp(columns["truth.tip_mm"]) == 0.0


def test_an_abort_ends_halted_with_the_tip_out() -> None:
    loop, start = ready()
    state, _ = trace.record(loop, start, START, 12.0)
    ended, columns = trace.record(loop, state, ABORT, 60.0)
    assert ended.tick < 72_000
    assert columns["phase"][0] == Phase.ABORTING
    assert columns["phase"][-1] == Phase.HALTED
    assert columns["truth.tip_mm"][-1] < 1.0


def test_a_trace_with_too_few_columns_is_refused() -> None:
    loop, start = ready()
    with pytest.raises(TypeError, match="columns"):
        closed_loop.run(loop, start, START, np.zeros((10, len(COLUMNS) - 1)))


def test_a_trace_that_is_no_table_of_rows_is_refused() -> None:
    """Machine code for rows of doubles would write past them."""
    loop, start = ready()
    columns = np.asfortranarray(trace.rows(0.05))
    for table in (columns, trace.rows(0.05).astype(np.float32), trace.rows(0.05)[:, ::-1]):
        with pytest.raises(TypeError, match="rows of doubles"):
            closed_loop.run(loop, start, START, table)  # type: ignore[arg-type]


@pytest.mark.skipif(not isinstance(closed_loop._run, CoreFunction), reason="nothing is compiled")
def test_a_whole_number_in_a_setting_compiles_nothing_anew() -> None:
    loop, start = ready()
    closed_loop.run(loop, start, NO_REQUESTS, trace.rows(0.05))
    before = len(closed_loop._run.overloads)  # type: ignore[attr-defined]
    settings = loop.controller
    whole = settings._replace(limits=settings.limits._replace(in_airway_s=30))
    floats = settings._replace(limits=settings.limits._replace(in_airway_s=30.0))
    tables = trace.rows(5.0), trace.rows(5.0)
    for chosen, table in zip((whole, floats), tables, strict=True):
        closed_loop.run(loop._replace(controller=chosen), start, START, table)
    np.testing.assert_array_equal(*tables)
    assert len(closed_loop._run.overloads) == before  # type: ignore[attr-defined]


def test_a_row_holds_what_was_read_before_the_machine_moved() -> None:
    _, columns = cycle(exact=True)
    # The encoder's reading is that of the same row's true motor; the head lags by the gear's play.
    apart = columns["truth.head_mm"] - columns["readings.head_mm"]
    assert np.max(np.abs(apart)) <= 0.5 * ready()[0].machine.gear_backlash_mm + 0.005
    assert np.all(np.diff(columns["time_s"]) > 0.0)
