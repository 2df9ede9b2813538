import pytest

from opensuction.kernel import row
from opensuction.kernel.commands import Commands
from opensuction.twin import machine, parameter, preset
from opensuction.twin.machine import Observation
from tests.conformance.plain import run_plain

DT_S = 0.001
TICKS = 2000


def script(tick: int) -> Commands:
    """Two seconds that use every part: the head crosses the gap and turns, the valve opens."""
    forth = tick < 1500
    return Commands(
        head_mm=0.0,
        insertion_v=20.0 if forth else -20.0,
        insertion_on=tick % 100 != 99,
        cam_rad=0.0,
        valve_v=12.0 if 50 < tick < 1500 else 0.0,
        valve_on=tick < 1600,
        pump_on=tick < 1800,
        vacuum_mmhg=100.0,
    )


def results() -> list[list[float]]:
    """Truth and readings of every tick, on a drawn machine whose carina is just ahead."""
    values = {**parameter.drawn(parameter.BENCH, 11), "carina_mm": 85.0}
    twin = preset.machine(values)
    state = preset.parked(twin, values, 85.0, seed=11, run=2)
    rows = []
    for tick in range(TICKS):
        state = machine.step(twin, state, script(tick), DT_S)
        truth = [float(value) for value in machine.observe(twin, state)]
        readings = [float(value) for value in machine.read(twin, state)]
        rows.append(truth + readings)
    return rows


def test_compiled_equals_plain_python() -> None:
    plain = run_plain("tests.conformance.test_machine_step", "results")
    assert isinstance(plain, list)
    compiled = results()
    assert len(plain) == len(compiled) == TICKS
    names = row.columns(Observation)
    last = dict(zip(names, compiled[-1], strict=False))
    # The script did reach everything it means to compare.
    assert last["secretion_removed_ml"] > 0.0
    assert max(tick[names.index("contact_n")] for tick in compiled) > 0.1
    for one, other in zip(plain, compiled, strict=True):
        # Same library functions; fused operations may differ in the last bit and then add up.
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9)
