"""The machine of the twin with its line and the airway at its tip: one pure step a tick.

The bedside behind the coupling steps more slowly; `opensuction.twin.plant` puts both together.
"""

import math
from typing import NamedTuple

from opensuction.hysteresis import play
from opensuction.kernel.compiled import compiled
from opensuction.kernel.interface import Commands, Readings
from opensuction.twin import coupling
from opensuction.twin.airway import airway
from opensuction.twin.airway.airway import Airway, AirwayState
from opensuction.twin.coupling import CouplingState
from opensuction.twin.machine import dc_axis, suction_line, tip_sensor, transmission
from opensuction.twin.machine.dc_axis import AxisMotion, DcAxis, Hand, HandState, ValveMechanism
from opensuction.twin.machine.suction_line import Bore, BoreState, SuctionLine, SuctionState
from opensuction.twin.machine.tip_sensor import ContactSwitch, Laser, LaserState, SwitchState
from opensuction.twin.machine.transmission import Transmission, TransmissionState
from opensuction.twin.patient import patient
from opensuction.twin.patient.patient import Patient
from opensuction.twin.sensor import sensor
from opensuction.twin.sensor.sensor import Measured, Sensors, SensorState

DRAWN_MM_PER_S = 3.0
"""[design] A tip that moves out faster is drawn out: creep after a stop is slower, 1 mm/s."""


class Machine(NamedTuple):
    """Parameters of one machine with one airway, a patient's or the bench's."""

    insertion_axis: DcAxis
    rack_from_mm: float
    """Where the rack ends behind the park position; a motor that pulls on stands there."""
    rack_to_mm: float
    """Where it ends in front."""
    gear_backlash_mm: float
    """Play between motor encoder and catheter head."""
    sensors: Sensors
    amperes_per_v: float
    """Insertion motor's current for each volt that drives current."""
    load_v_per_n: float
    """Voltage that balances a force on the catheter head."""
    clamp_slip_ratio: float
    """Share of the head's travel that the clamp does not give to the catheter; 0 if it holds."""
    mouth_mm: float
    """Where the light barrier above the tube's mouth is; a deeper tip has the catheter in its beam.
    Infinite on the bench, which has no connector."""
    weak_tip_mm: float
    """Length of a tip that parts as soon as it is drawn out inside the patient; 0 if it holds."""
    transmission: Transmission
    valve_axis: DcAxis
    valve: ValveMechanism
    line: SuctionLine
    bore: Bore
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
    slipped_mm: float
    """Head travel that the catheter has not followed, for its clamp slipped."""
    piece_mm: float
    """Length of the tip that has parted and lies in the airway; 0 for none."""
    transmission: TransmissionState
    valve: AxisMotion
    line: SuctionState
    bore: BoreState
    airway: AirwayState
    switch: SwitchState
    laser: LaserState
    sensed: SensorState
    coupling: CouplingState
    hand: HandState


class Truth(NamedTuple):
    """The truth that only the twin knows, for trace and scoring."""

    head_mm: float
    tip_mm: float
    laser_mm: float
    contact_n: float
    valve_open_ratio: float
    tip_vacuum_mmhg: float
    gas_ml_per_s: float
    secretion_removed_ml: float
    """Out of the patient: in bore or canister."""
    bore_ml: float
    """Mucus in the catheter's bore."""
    canister_ml: float
    """Liquid in the canister."""
    line_vacuum_mmhg: float
    """In the canister; what is read there may be wrong."""
    airway_pressure_cmh2o: float
    """In the trachea; this and what follows are 0 where there is no patient."""
    lung_volume_ml: float
    lung_volume_loss_ml: float
    spo2_percent: float
    heart_rate_per_min: float
    piece_mm: float
    """Length of a piece of the catheter that lies loose in the airway; 0 for none."""
    carina_shift_mm: float
    """How much deeper the carina is than at the start."""
    muscle_cmh2o: float
    """Pressure of the patient's muscles on the lung."""
    relaxed_pressure_cmh2o: float
    """In the trachea, had the muscles never moved."""
    relaxed_loss_ml: float
    """Lung volume lost, likewise."""


@compiled
def read(machine: Machine, state: MachineState) -> Readings:
    """Readings that the sensors report."""
    sensed = state.sensed
    return Readings(
        head_mm=sensed.head_mm,
        head_valid=True,
        carriage_mm=sensed.carriage_mm,
        carriage_valid=True,
        cam_rad=sensed.cam_rad,
        cam_valid=True,
        line_vacuum_mmhg=sensed.vacuum_mmhg,
        vacuum_valid=True,
        contact_closed=state.switch.reading,
        contact_valid=machine.switch.wired and state.piece_mm == 0.0,
        mouth_clear=state.airway.tip_mm <= machine.mouth_mm,
        insertion_current_a=sensed.current_a,
        monitor=state.coupling.signs.monitor,
    )


@compiled
def measure(
    machine: Machine, insertion: AxisMotion, head_mm: float, cam_rad: float, vacuum_mmhg: float
) -> Measured:
    """The truth of what the sensors measure."""
    return Measured(
        head_mm=dc_axis.encoder(machine.insertion_axis, insertion),
        carriage_mm=head_mm,
        cam_rad=cam_rad,
        vacuum_mmhg=vacuum_mmhg,
        current_a=machine.amperes_per_v * insertion.drive_v,
    )


@compiled
def _lost_mmhg(machine: Machine, state: MachineState, opened: float) -> float:
    """Vacuum that mucus in the bore takes, the valve being that far open."""
    return suction_line.lost_mmhg(
        machine.bore,
        state.bore,
        state.line.vacuum_mmhg,
        opened * state.airway.free_share * machine.line.bore_ml_per_s_per_root_mmhg,
    )


@compiled
def _step_valve(
    machine: Machine, state: MachineState, commands: Commands, dt_s: float
) -> AxisMotion:
    """The valve's axis a tick on, against its spring and its end stop."""
    turned = dc_axis.step(
        machine.valve_axis,
        state.valve,
        commands.valve_v,
        commands.valve_on,
        dc_axis.load_v(machine.valve, state.valve.position),
        dt_s,
    )
    return dc_axis.stopped(turned, -machine.valve.stop_rad, math.inf)


@compiled
def truth(machine: Machine, state: MachineState) -> Truth:
    """The truth in a state."""
    signs = state.coupling.signs
    opened = dc_axis.open_ratio(machine.valve, state.valve.position)
    return Truth(
        head_mm=state.head_mm,
        tip_mm=state.airway.tip_mm,
        laser_mm=state.laser.reading_mm,
        contact_n=state.airway.contact_n,
        valve_open_ratio=opened,
        tip_vacuum_mmhg=opened * (state.line.vacuum_mmhg - _lost_mmhg(machine, state, opened)),
        gas_ml_per_s=state.line.gas_ml_per_s,
        secretion_removed_ml=state.airway.removed_ml,
        bore_ml=state.bore.mucus_ml,
        canister_ml=state.bore.canister_ml,
        line_vacuum_mmhg=state.line.vacuum_mmhg,
        airway_pressure_cmh2o=signs.airway_pressure_cmh2o,
        lung_volume_ml=signs.lung_volume_ml,
        lung_volume_loss_ml=signs.lung_volume_loss_ml,
        spo2_percent=signs.spo2_percent,
        heart_rate_per_min=signs.heart_rate_per_min,
        piece_mm=state.piece_mm,
        carina_shift_mm=state.coupling.carina_shift_mm,
        muscle_cmh2o=signs.muscle_cmh2o,
        relaxed_pressure_cmh2o=signs.relaxed_pressure_cmh2o,
        relaxed_loss_ml=signs.relaxed_loss_ml,
    )


@compiled
def _part_tip(machine: Machine, state: MachineState, moved_mm: float, dt_s: float) -> float:
    """Length of the tip that lies in the airway after the catheter's free end has moved.

    A weak tip parts as it is drawn out inside the patient. moved_mm: the free end of a whole tip.
    """
    drawn = state.transmission.tip_mm - moved_mm > DRAWN_MM_PER_S * dt_s
    inside = machine.has_patient and patient.is_inside(machine.patient, state.airway.tip_mm)
    if state.piece_mm == 0.0 and drawn and inside:
        return machine.weak_tip_mm
    return state.piece_mm


@compiled
def _step_insertion(
    machine: Machine, state: MachineState, commands: Commands, dt_s: float
) -> tuple[AxisMotion, HandState]:
    """The insertion axis a tick on, within its rack, and the hand that may hold its head."""
    insertion = dc_axis.step(
        machine.insertion_axis,
        state.insertion,
        commands.insertion_v,
        commands.insertion_on,
        machine.load_v_per_n * state.airway.contact_n,
        dt_s,
    )
    held = state.hand
    if machine.hand.present and not commands.insertion_on and dc_axis.is_gripping(held):
        held, insertion = dc_axis.step_hand(
            machine.hand, held, state.insertion, state.airway.contact_n, dt_s
        )
    return dc_axis.stopped(insertion, machine.rack_from_mm, machine.rack_to_mm), held


@compiled
def _around(machine: Machine, state: MachineState) -> tuple[Transmission, Airway]:
    """Conduit and airway as the patient lies now."""
    conduit, lower = machine.transmission, machine.airway
    if state.coupling.gap_ratio != 1.0:
        conduit = transmission.widen(conduit, state.coupling.gap_ratio)
    return conduit, lower._replace(carina_mm=lower.carina_mm + state.coupling.carina_shift_mm)


@compiled
def step(machine: Machine, state: MachineState, commands: Commands, dt_s: float) -> MachineState:
    """Advance the machine by one tick under the given commands."""
    insertion, held = _step_insertion(machine, state, commands, dt_s)
    head = play.step(machine.gear_backlash_mm, state.head_mm, insertion.position)
    slipped = state.slipped_mm + machine.clamp_slip_ratio * (head - state.head_mm)
    conduit, lower_airway = _around(machine, state)
    moved = transmission.step(conduit, state.transmission, head - slipped, dt_s)
    piece = state.piece_mm
    if machine.weak_tip_mm > 0.0:
        piece = _part_tip(machine, state, moved.tip_mm, dt_s)
    valve = _step_valve(machine, state, commands, dt_s)
    opened = dc_axis.open_ratio(machine.valve, valve.position)
    lost = _lost_mmhg(machine, state, opened)
    line = suction_line.step(
        machine.line,
        state.line,
        commands.pump_on,
        commands.vacuum_mmhg,
        opened * state.airway.free_share,
        lost,
        dt_s,
    )
    touched = airway.step(
        lower_airway,
        state.airway,
        moved.tip_mm - piece,
        max(line.vacuum_mmhg - lost, 0.0) * opened,
        state.coupling.reachable_ml,
        dt_s,
    )
    # The switch is in the tip, and parts with it.
    pressed_n = touched.contact_n if piece == 0.0 else 0.0
    inside = machine.has_patient and patient.is_inside(machine.patient, touched.tip_mm)
    gas_ml = line.gas_ml_per_s * dt_s if inside else 0.0
    measured = measure(machine, insertion, head, valve.position, line.vacuum_mmhg)
    return MachineState(
        insertion=insertion,
        head_mm=head,
        slipped_mm=slipped,
        piece_mm=piece,
        transmission=moved,
        valve=valve,
        line=line,
        bore=suction_line.step_bore(
            machine.bore, state.bore, touched.taken_ml, line.gas_ml_per_s, dt_s
        ),
        airway=touched,
        switch=tip_sensor.step(machine.switch, state.switch, pressed_n, dt_s),
        laser=tip_sensor.step_laser(machine.laser, state.laser, touched.tip_mm),
        sensed=sensor.step(machine.sensors, state.sensed, measured, dt_s),
        coupling=coupling.accumulate(state.coupling, gas_ml, touched.taken_ml),
        hand=held,
    )
