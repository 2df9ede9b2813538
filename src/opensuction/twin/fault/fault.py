"""Faults that the twin can have: their names, numbers, and what each attacks.

What each means, and how strong it can be, is in `fault_table`; what it does to a machine in
`fault_effect`.
"""

from enum import IntEnum


class Fault(IntEnum):
    """A fault. The numbers are stored in results: never renumber."""

    SWITCH_STUCK_OPEN = 1
    SWITCH_STUCK_CLOSED = 2
    SWITCH_BRIDGED = 3
    SWITCH_STICKING = 4
    SWITCH_BOUNCING = 5
    SWITCH_STIFF = 6
    SWITCH_LATE = 7
    SWITCH_INVALID = 8

    CARINA_MISSED = 10
    TUBE_DISPLACED = 11
    TIP_BUCKLING = 12
    TIP_DETACHED = 13

    CATHETER_KINKED = 20
    CATHETER_JAMMED = 21
    CONDUIT_REROUTED = 22

    MOTOR_STALLED = 30
    MOTOR_LOST = 31
    MOTOR_WEAK = 32
    MOTOR_REVERSED = 33
    GEAR_LOST = 34
    GEAR_WORN = 35

    ENCODER_FROZEN = 40
    ENCODER_SLIPPING = 41
    ENCODER_JUMPING = 42
    ENCODER_OFFSET = 43
    ENCODER_NOISY = 44
    ENCODER_INVALID = 45
    ENCODER_REVERSED = 46
    CURRENT_SENSOR_DEAD = 47
    CARRIAGE_SENSOR_FROZEN = 48
    CARRIAGE_SENSOR_INVALID = 49

    VALVE_STUCK_OPEN = 50
    VALVE_STUCK_CLOSED = 51
    VALVE_SLOW = 52
    VALVE_JAMMED = 53
    VALVE_MOTOR_LOST = 54
    VALVE_SPRING_BROKEN = 55

    CAM_ENCODER_FROZEN = 60
    CAM_ENCODER_OFFSET = 61
    CAM_ENCODER_NOISY = 62
    CAM_ENCODER_INVALID = 63

    PUMP_RUNAWAY = 70
    PUMP_WEAK = 71
    PUMP_LOST = 72
    REGULATOR_FAILED = 73
    RELIEF_FAILED = 74
    LINE_LEAK = 75
    LINE_CLOGGED = 76
    CANISTER_FULL = 77

    VACUUM_SENSOR_FROZEN = 80
    VACUUM_SENSOR_OFFSET = 81
    VACUUM_SENSOR_NOISY = 82
    VACUUM_SENSOR_INVALID = 83

    POWER_LOST = 90
    POWER_LOST_WITHOUT_RESERVE = 91

    CONTROLLER_STOPPED = 100
    TICK_LATE = 101

    MESSAGE_LATE = 110
    MESSAGE_LOST = 111
    MESSAGE_REPEATED = 112
    READING_LATE = 113
    READING_LOST = 114
    READING_REPEATED = 115

    CIRCUIT_DISCONNECTED = 120
    VENTILATOR_PRESSURE = 121
    DESATURATION = 122
    BRADYCARDIA = 123
    LUNG_VOLUME_LOST = 124
    MONITOR_LOST = 125

    WRONG_PRESET = 140
    CATHETER_TOO_WIDE = 141
    CATHETER_EXPIRED = 142
    TAUGHT_TOO_DEEP = 143

    @property
    def title(self) -> str:
        """Its name on the command line and in JSON."""
        return self.name.lower().replace("_", "-")


class Part(IntEnum):
    """What a fault attacks, and with it how it comes into a run."""

    SWITCH = 0
    TIP = 1
    CATHETER = 2
    INSERTION_DRIVE = 3
    HEAD_ENCODER = 4
    VALVE = 5
    CAM_ENCODER = 6
    SUCTION_LINE = 7
    VACUUM_SENSOR = 8
    POWER = 9
    CONTROLLER = 10
    MESSAGE = 11
    PATIENT = 12
    SETTING = 13


class Means(IntEnum):
    """How a fault comes into a run."""

    MACHINE = 0
    """The twin's parameters change at the instant: `fault_effect.faulty`."""
    READING = 1
    """What is read changes on its way to the controller: `reading_fault`."""
    LINK = 2
    """Power, controller or messages between it and the drives fail."""
    SETTING = 3
    """The machine was set up wrongly before the start."""


BY_NAME = {fault.title: fault for fault in Fault}
"""Faults by the name that is used on the command line."""
