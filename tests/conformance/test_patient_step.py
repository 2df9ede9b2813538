import pytest

from opensuction.twin.patient import patient, patient_preset
from tests.conformance.plain import run_plain

STEPS = 3000


def results() -> list[list[float]]:
    """Half a minute of a drawn patient: the catheter comes, sucks hard and goes."""
    one = patient_preset.patient("adult-ards", 4)
    # Not settled: plain Python would take seconds for that, and a transient compares more.
    state = patient_preset.near_rest(one)
    rows = []
    for step in range(STEPS):
        suction = 700.0 if 500 < step < 1500 else 0.0
        ratio = 0.47 if 400 < step < 1800 else 0.0
        state = patient.step(one, state, suction, ratio, 0.5, 0.01)
        rows.append(
            [
                *patient.signs(one, state)[:5],
                *state.vitals.airflow,
                *state.vitals.gas,
                state.vitals.breath.tidal_ml,
            ]
        )
    return rows


def test_compiled_equals_plain_python() -> None:
    plain = run_plain("tests.conformance.test_patient_step", "results")
    assert isinstance(plain, list)
    compiled = results()
    assert len(plain) == len(compiled) == STEPS
    for one, other in zip(plain, compiled, strict=True):
        # Same library functions; fused operations may differ in the last bit and then add up.
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9)
