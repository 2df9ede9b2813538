"""Effects of faults of clamp, tip, tube, motor, mains and patient, played on a patient."""

from functools import cache

import numpy as np
import pytest

from opensuction.kernel.vocabulary import Phase
from opensuction.safety.condition import Condition
from opensuction.session.choice import CycleChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.simulation import outcome
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.injection import injection
from opensuction.simulation.injection.fault_instant import FaultInstant, Injection
from opensuction.simulation.injection.injection import InjectedRun
from opensuction.simulation.trace import Columns
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_table import COUGH_S, ROWS, SHORTENING_MM_PER_CMH2O

ADDED = [fault for fault in Fault if fault >= Fault.ENCODER_GLITCH]


@cache
def prepared() -> Prepared:
    return cycle_run.prepare(resolution.resolve(CycleChoice(compensation="exact-inverse")))


def ran(
    fault: Fault,
    strength: float | None = None,
    phase: Phase = Phase.SUCTIONING,
    after_s: float = 2.0,
    resets: int = 0,
) -> InjectedRun:
    strong = ROWS[fault].default_strength if strength is None else strength
    come = Injection(fault, FaultInstant(phase, after_s), strong)
    cycle = prepared()
    return injection.run(cycle.loop, cycle.start, [come], after_s=1.0, resets=resets)


@cache
def sound() -> Columns:
    """The same cycle without a fault."""
    cycle = prepared()
    return injection.run(cycle.loop, cycle.start, [], after_s=1.0).columns


def first_tick(run: InjectedRun) -> int:
    return round(run.faults[0].at_s / DT_S)


@pytest.mark.parametrize("fault", ADDED, ids=lambda fault: fault.title)
def test_a_cycle_with_each_runs_to_its_end(fault: Fault) -> None:
    """The fault comes, its like before is the sound cycle, and the machine rests at the end."""
    run = ran(fault, phase=Phase.WITHDRAWING, after_s=0.5)
    assert run.columns["phase"][-1] in (Phase.PARKED, Phase.HALTED)
    first = first_tick(run)
    for name in ("truth.tip_mm", "readings.head_mm", "commands.insertion_v"):
        assert np.array_equal(run.columns[name][:first], sound()[name][:first])
    assert np.all(np.isfinite(run.columns["truth.tip_mm"]))


def test_a_clamp_that_slips_leaves_the_tip_behind_the_head() -> None:
    run = ran(Fault.CLAMP_SLIPPING, 0.2)
    first, head = first_tick(run), run.columns["truth.head_mm"]
    behind = run.columns["truth.tip_mm"][-1] - sound()["truth.tip_mm"][-1]
    # The barrier tells it, and the head goes 5 mm further back than home, less a fifth.
    assert head[-1] < sound()["truth.head_mm"][-1] - 4.0
    further = 0.8 * (sound()["truth.head_mm"][-1] - head[-1])
    # A fifth of the way home; the gap, crossed at less than the head's travel, is in it.
    assert behind + further == pytest.approx(0.2 * (head[first] - head[-1]), abs=3.0)
    assert run.columns["readings.head_mm"][-1] == pytest.approx(head[-1], abs=0.1)


def test_a_tip_that_breaks_off_on_the_way_out_stays_in_the_airway() -> None:
    run = ran(Fault.TIP_LEFT_BEHIND, 20.0, Phase.INSERTING, 5.0)
    piece, phase = run.columns["truth.piece_mm"], run.columns["phase"]
    parted = int(np.argmax(piece > 0.0))
    assert set(np.unique(piece)) == {0.0, 20.0}
    assert phase[parted] in (Phase.SUCTIONING, Phase.WITHDRAWING)
    assert np.all(piece[parted:] == 20.0)
    shorter = sound()["truth.tip_mm"] - run.columns["truth.tip_mm"][: sound()["time_s"].size]
    assert shorter[parted - 1] == 0.0
    assert shorter[parted] == pytest.approx(20.0, abs=1e-9)


def test_a_weak_tip_outside_the_patient_stays_whole() -> None:
    run = ran(Fault.TIP_LEFT_BEHIND, 20.0, Phase.CLOSING, 0.2)
    assert not run.columns["truth.piece_mm"].any()


def test_a_cough_is_a_pulse_of_pressure_and_a_carina_that_comes_nearer() -> None:
    run = ran(Fault.COUGH, 60.0, after_s=0.3)
    first = first_tick(run)
    ticks = round(COUGH_S / DT_S)
    lung = run.columns["truth.airway_pressure_cmh2o"] - np.resize(
        sound()["truth.airway_pressure_cmh2o"], run.columns["time_s"].size
    )
    assert np.max(lung[first : first + ticks]) > 5.0
    assert np.max(np.abs(lung[:first])) == 0.0
    # At the tip's depth, 10 mm above the carina, a cough of 60 cmH2O lacks a millimetre.
    assert pytest.approx(9.0) == SHORTENING_MM_PER_CMH2O * 60.0
    assert np.max(run.columns["truth.contact_n"]) == 0.0
    hard = ran(Fault.COUGH, 150.0, after_s=0.3)
    touched = np.flatnonzero(hard.columns["truth.contact_n"])
    assert touched.size
    assert first < touched[0]
    assert touched[-1] < first + ticks


def test_a_tube_that_comes_out_takes_the_catheter_with_it() -> None:
    run = ran(Fault.DECANNULATION, 120.0)
    first = first_tick(run)
    tip = run.columns["truth.tip_mm"]
    assert tip[first + 1] - tip[first - 1] == pytest.approx(-120.0, abs=1.0)
    shown = run.columns["readings.monitor.airway_pressure_cmh2o"]
    assert np.all(np.abs(shown[first + 20 :]) < 0.1)
    told = {item.condition for item in outcome.told(run.columns)}
    assert Condition.CIRCUIT_DISCONNECTED in told


def test_a_loose_contact_of_the_motor_drives_every_other_turn() -> None:
    run = ran(Fault.MOTOR_INTERMITTENT, 0.1, Phase.WITHDRAWING, 0.5)
    first = first_tick(run)
    current = np.abs(run.columns["readings.insertion_current_a"][first + 1 : first + 801])
    turns = current.reshape(8, 100)
    # Nothing but the sensor's noise, and what is left of its bandwidth after a few ticks.
    noise_a = 5.0 * prepared().loop.machine.sensors.current.noise
    assert np.all(turns[0::2, 10:-1] < noise_a)
    assert np.all(turns[1::2].max(axis=1) > noise_a)


def test_mains_that_come_back_start_a_new_controller() -> None:
    run = ran(Fault.POWER_RETURNING, 3.0, resets=1)
    first = first_tick(run)
    back = first + 3000
    gone = run.columns["annunciator.reserve_used"]
    assert not gone[:first].any()
    assert gone[first:back].all()
    assert not gone[back:].any()
    assert np.all(run.columns["phase"][first:back] == Phase.HALTED)
    assert run.columns["phase"][-1] == Phase.PARKED


def test_what_was_broken_besides_stays_broken_when_the_mains_come_back() -> None:
    cycle = prepared()
    at = FaultInstant(Phase.SUCTIONING, 1.0)
    both = [
        Injection(Fault.POWER_RETURNING, at, 0.5),
        Injection(Fault.SWITCH_STUCK_CLOSED, at, 0.0),
    ]
    run = injection.run(cycle.loop, cycle.start, both, after_s=1.0)
    assert np.all(run.columns["readings.contact_closed"][first_tick(run) + 20 :] == 1.0)


def test_readings_ten_ticks_late_are_so_from_the_instant_on() -> None:
    run = ran(Fault.READING_LATE, 0.01, Phase.WITHDRAWING, 0.3)
    first = first_tick(run)
    read, true = run.columns["readings.carriage_mm"], run.columns["truth.head_mm"]
    carriage = prepared().loop.machine.sensors.carriage
    # Half a step, the zero, the noise, and a tick of age at 30 mm/s.
    step_mm = carriage.step + abs(carriage.offset) + 2.0 * carriage.noise + 0.03
    for tick in (first, first + 1, first + 9, first + 10, first + 500):
        assert read[tick] == pytest.approx(true[tick - 10], abs=step_mm)
    assert read[first - 1] == pytest.approx(true[first - 1], abs=step_mm)
