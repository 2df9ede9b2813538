"""The twin: machine, line, airway and patient put together, one pure step a tick."""

from typing import NamedTuple

from opensuction.hysteresis import play
from opensuction.kernel.commands import Commands
from opensuction.kernel.compiled import compiled
from opensuction.kernel.readings import Readings
from opensuction.twin import (
    airway,
    bedside,
    contact_switch,
    dc_axis,
    hand,
    laser,
    patient,
    suction_line,
    transmission,
    valve_mechanism,
)
from opensuction.twin.airway import Airway, AirwayState
from opensuction.twin.bedside import SeamState
from opensuction.twin.contact_switch import ContactSwitch, SwitchState
from opensuction.twin.dc_axis import AxisMotion, DcAxis
from opensuction.twin.hand import Hand, HandState
from opensuction.twin.laser import Laser, LaserState
from opensuction.twin.patient import Patient, PatientState
from opensuction.twin.suction_line import SuctionLine, SuctionState
from opensuction.twin.transmission import Transmission, TransmissionState
from opensuction.twin.valve_mechanism import ValveMechanism


class Machine(NamedTuple):
    """Parameters of one machine with one airway, a patient's or the bench's."""

    insertion_axis: DcAxis
    gear_backlash_mm: float
    """Play between motor encoder and catheter head."""
    amperes_per_v: float
    """Insertion motor's current for each volt that drives current."""
    load_v_per_n: float
    """Voltage that balances a force on the catheter head."""
    transmission: Transmission
    valve_axis: DcAxis
    valve: ValveMechanism
    line: SuctionLine
    airway: Airway
    switch: ContactSwitch
    laser: Laser
    patient: Patient
    has_patient: bool
    """Whether anybody is there: the bench has only a rubber trachea."""
    catheter_mm: float
    """Outer diameter of the catheter."""
    hand: Hand
    """Of a person at the catheter head."""


class MachineState(NamedTuple):
    """State of one machine with one airway."""

    insertion: AxisMotion
    head_mm: float
    """Catheter head behind gear and rack."""
    transmission: TransmissionState
    valve: AxisMotion
    line: SuctionState
    airway: AirwayState
    switch: SwitchState
    laser: LaserState
    patient: PatientState
    seam: SeamState
    hand: HandState


class Observation(NamedTuple):
    """The truth that only the twin knows, for trace and scoring."""

    head_mm: float
    tip_mm: float
    laser_mm: float
    contact_n: float
    valve_open_ratio: float
    tip_vacuum_mmhg: float
    gas_ml_per_s: float
    secretion_removed_ml: float
    airway_pressure_cmh2o: float
    """In the trachea; this and what follows are 0 where there is no patient."""
    lung_volume_ml: float
    lung_volume_loss_ml: float
    spo2_percent: float


@compiled
def read(machine: Machine, state: MachineState) -> Readings:
    """What the sensors report."""
    return Readings(
        head_mm=dc_axis.encoder(machine.insertion_axis, state.insertion),
        head_valid=True,
        cam_rad=dc_axis.encoder(machine.valve_axis, state.valve),
        cam_valid=True,
        line_vacuum_mmhg=state.line.vacuum_mmhg,
        vacuum_valid=True,
        contact_closed=state.switch.reading,
        contact_valid=True,
        insertion_current_a=machine.amperes_per_v * state.insertion.drive_v,
    )


@compiled
def tip_vacuum_mmhg(machine: Machine, state: MachineState) -> float:
    """Vacuum that draws mucus at the tip: line vacuum behind the valve's opening."""
    return state.line.vacuum_mmhg * valve_mechanism.open_ratio(machine.valve, state.valve.position)


@compiled
def observe(machine: Machine, state: MachineState) -> Observation:
    """What really is."""
    pressure = volume = loss = saturation = 0.0
    if machine.has_patient:
        seen = patient.observe(machine.patient, state.patient)
        pressure = seen.airway_pressure_cmh2o
        volume = seen.lung_volume_ml
        loss = seen.lung_volume_loss_ml
        saturation = seen.spo2_percent
    return Observation(
        head_mm=state.head_mm,
        tip_mm=state.airway.tip_mm,
        laser_mm=state.laser.reading_mm,
        contact_n=state.airway.contact_n,
        valve_open_ratio=valve_mechanism.open_ratio(machine.valve, state.valve.position),
        tip_vacuum_mmhg=tip_vacuum_mmhg(machine, state),
        gas_ml_per_s=state.line.gas_ml_per_s,
        secretion_removed_ml=state.airway.removed_ml,
        airway_pressure_cmh2o=pressure,
        lung_volume_ml=volume,
        lung_volume_loss_ml=loss,
        spo2_percent=saturation,
    )


@compiled
def step(machine: Machine, state: MachineState, commands: Commands, dt_s: float) -> MachineState:
    """Advance everything by one tick under the given commands."""
    insertion = dc_axis.step(
        machine.insertion_axis,
        state.insertion,
        commands.insertion_v,
        commands.insertion_on,
        machine.load_v_per_n * state.airway.contact_n,
        dt_s,
    )
    held = state.hand
    if machine.hand.present and not commands.insertion_on and hand.is_gripping(held):
        held, insertion = hand.step(
            machine.hand, held, state.insertion, state.airway.contact_n, dt_s
        )
    head = play.step(machine.gear_backlash_mm, state.head_mm, insertion.position)
    moved = transmission.step(machine.transmission, state.transmission, head, dt_s)
    turned = dc_axis.step(
        machine.valve_axis,
        state.valve,
        commands.valve_v,
        commands.valve_on,
        valve_mechanism.load_v(machine.valve, state.valve.position),
        dt_s,
    )
    valve = valve_mechanism.stopped(machine.valve, turned)
    opened = valve_mechanism.open_ratio(machine.valve, valve.position)
    line = suction_line.step(
        machine.line,
        state.line,
        commands.pump_on,
        commands.vacuum_mmhg,
        opened * state.airway.free_share,
        dt_s,
    )
    touched = airway.step(
        machine.airway, state.airway, moved.tip_mm, line.vacuum_mmhg * opened, dt_s
    )
    breathing, seam = state.patient, state.seam
    if machine.has_patient:
        breathing, seam = bedside.step(
            machine.patient,
            state.patient,
            state.seam,
            touched.tip_mm,
            line.gas_ml_per_s * dt_s,
            machine.catheter_mm,
            dt_s,
        )
    return MachineState(
        insertion=insertion,
        head_mm=head,
        transmission=moved,
        valve=valve,
        line=line,
        airway=touched,
        switch=contact_switch.step(machine.switch, state.switch, touched.contact_n, dt_s),
        laser=laser.step(machine.laser, state.laser, touched.tip_mm),
        patient=breathing,
        seam=seam,
        hand=held,
    )
