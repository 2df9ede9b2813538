"""Cost of a tick for a loop that calls the controller from Python: by rows, and by Controller.

The inputs are those of a ventilated adult's whole cycle. The times are processor time, with that of
the clock itself; how long the operating system lets a process wait concerns the loop around it.
Garbage collection is on, but does not visit the objects that only the benchmark keeps. Nothing is
asserted about time.
"""

import gc
from collections.abc import Callable
from time import thread_time_ns

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.conftest import Tell
from benchmarks.timing import best_s, is_timed
from opensuction.controller.configuration import Configuration
from opensuction.controller.real_time_call import INPUT_COLUMNS, OUTPUT_COLUMNS, RealTimeCall
from opensuction.controller.record import Inputs
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.interface import START
from opensuction.kernel.record import Array
from opensuction.runtime.embedded_controller import Controller
from opensuction.session.choice import CycleChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import trace
from opensuction.simulation.closed_loop import DT_S

ROUNDS = 3


def recorded() -> tuple[Prepared, Array]:
    """A cycle, and the rows of inputs that its controller had."""
    prepared = cycle_run.prepare(resolution.resolve(CycleChoice()))
    _, columns = trace.record(prepared.loop, prepared.start, START, 120.0)
    rows = np.zeros((columns["time_s"].size, len(INPUT_COLUMNS)))
    for i, name in enumerate(INPUT_COLUMNS):
        if name.startswith("readings."):
            rows[:, i] = columns[name]
    for name in ("start", "oxygen_skipped"):
        rows[0, INPUT_COLUMNS.index(f"requests.{name}")] = 1.0
    rows[:, INPUT_COLUMNS.index("dt_s")] = DT_S
    return prepared, rows


def percentiles_us(step: Callable[[int], object], ticks: int) -> Array:
    """Median, 99 %, 99.9 % and longest of the calls, us."""
    gc.freeze()
    taken = np.zeros(ticks)
    for tick in range(ticks):
        begun = thread_time_ns()
        step(tick)
        taken[tick] = thread_time_ns() - begun
    gc.unfreeze()
    return np.percentile(taken / 1000.0, [50.0, 99.0, 99.9, 100.0])


def say(tell: Tell, benchmark: BenchmarkFixture, name: str, found: Array, ticks: int) -> None:
    p50, p99, p999, most = found
    benchmark.extra_info[name] = {"p50_us": p50, "p99_us": p99, "p99.9_us": p999, "max_us": most}
    tell(
        f"{name}, {ticks:,} ticks from Python: median {p50:.1f} us, 99 % {p99:.1f} us, "
        f"99.9 % {p999:.1f} us, longest {most:.0f} us"
    )


def test_real_time_call(benchmark: BenchmarkFixture, tell: Tell) -> None:
    prepared, rows = recorded()
    loop, state = prepared.loop, prepared.start.controller
    call, outputs = RealTimeCall(loop.controller, loop.heads_mm, state), np.zeros(OUTPUT_COUNT)
    for _ in range(ROUNDS if is_timed(benchmark) else 1):
        call.state = state
        found = percentiles_us(lambda tick: call.step(rows[tick], outputs), len(rows))
    say(tell, benchmark, "real-time call", found, len(rows))
    table = np.zeros((len(rows), OUTPUT_COUNT))
    shortest_s = best_s(benchmark, lambda: call.run(rows, table), rounds=5)
    tell(f"real-time call, all ticks at once: {shortest_s / len(rows) * 1e9:.0f} ns a tick")


def test_embedded_controller(benchmark: BenchmarkFixture, tell: Tell) -> None:
    prepared, rows = recorded()
    inputs = [plain_row.unpack(Inputs, row) for row in rows]
    chosen = Controller(Configuration(prepared.loop.controller, prepared.loop.heads_mm))

    def step(tick: int) -> object:
        one = inputs[tick]
        said = chosen.step(one.readings, one.requests, DT_S)
        return said.commands, said.trips, said.alarms

    for _ in range(ROUNDS if is_timed(benchmark) else 1):
        chosen.state = prepared.start.controller
        found = percentiles_us(step, len(inputs))
    say(tell, benchmark, "opensuction.Controller", found, len(inputs))
    one = inputs[0]
    benchmark(chosen.step, one.readings, one.requests, DT_S)


OUTPUT_COUNT = len(OUTPUT_COLUMNS)
