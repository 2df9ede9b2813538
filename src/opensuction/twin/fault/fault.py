"""Names and numbers of the faults that the twin can have; `fault_table` has a row for each."""

from enum import IntEnum

from opensuction.kernel.vocabulary import name_of


class FaultSite(IntEnum):
    """Site that a fault attacks, in the order of the documentation."""

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


class Fault(IntEnum):
    """A fault, by its number and what it attacks. Results hold the numbers: never renumber."""

    site: FaultSite

    def __new__(cls, number: int, *site: FaultSite) -> "Fault":
        """Member with the number as its value."""
        member = int.__new__(cls, number)
        member._value_ = number
        (member.site,) = site
        return member

    SWITCH_STUCK_OPEN = (1, FaultSite.SWITCH)
    SWITCH_STUCK_CLOSED = (2, FaultSite.SWITCH)
    SWITCH_BRIDGED = (3, FaultSite.SWITCH)
    SWITCH_STICKING = (4, FaultSite.SWITCH)
    SWITCH_BOUNCING = (5, FaultSite.SWITCH)
    SWITCH_STIFF = (6, FaultSite.SWITCH)
    SWITCH_LATE = (7, FaultSite.SWITCH)
    SWITCH_INVALID = (8, FaultSite.SWITCH)

    CARINA_MISSED = (10, FaultSite.TIP)
    TUBE_DISPLACED = (11, FaultSite.TIP)
    TIP_BUCKLING = (12, FaultSite.TIP)
    TIP_DETACHED = (13, FaultSite.TIP)

    CATHETER_KINKED = (20, FaultSite.CATHETER)
    CATHETER_JAMMED = (21, FaultSite.CATHETER)
    CONDUIT_REROUTED = (22, FaultSite.CATHETER)

    MOTOR_STALLED = (30, FaultSite.INSERTION_DRIVE)
    MOTOR_LOST = (31, FaultSite.INSERTION_DRIVE)
    MOTOR_WEAK = (32, FaultSite.INSERTION_DRIVE)
    MOTOR_REVERSED = (33, FaultSite.INSERTION_DRIVE)
    GEAR_LOST = (34, FaultSite.INSERTION_DRIVE)
    GEAR_WORN = (35, FaultSite.INSERTION_DRIVE)

    ENCODER_FROZEN = (40, FaultSite.HEAD_ENCODER)
    ENCODER_SLIPPING = (41, FaultSite.HEAD_ENCODER)
    ENCODER_JUMPING = (42, FaultSite.HEAD_ENCODER)
    ENCODER_OFFSET = (43, FaultSite.HEAD_ENCODER)
    ENCODER_NOISY = (44, FaultSite.HEAD_ENCODER)
    ENCODER_INVALID = (45, FaultSite.HEAD_ENCODER)
    ENCODER_REVERSED = (46, FaultSite.HEAD_ENCODER)
    CURRENT_SENSOR_DEAD = (47, FaultSite.INSERTION_DRIVE)
    CARRIAGE_SENSOR_FROZEN = (48, FaultSite.HEAD_ENCODER)
    CARRIAGE_SENSOR_INVALID = (49, FaultSite.HEAD_ENCODER)

    VALVE_STUCK_OPEN = (50, FaultSite.VALVE)
    VALVE_STUCK_CLOSED = (51, FaultSite.VALVE)
    VALVE_SLOW = (52, FaultSite.VALVE)
    VALVE_JAMMED = (53, FaultSite.VALVE)
    VALVE_MOTOR_LOST = (54, FaultSite.VALVE)
    VALVE_SPRING_BROKEN = (55, FaultSite.VALVE)

    CAM_ENCODER_FROZEN = (60, FaultSite.CAM_ENCODER)
    CAM_ENCODER_OFFSET = (61, FaultSite.CAM_ENCODER)
    CAM_ENCODER_NOISY = (62, FaultSite.CAM_ENCODER)
    CAM_ENCODER_INVALID = (63, FaultSite.CAM_ENCODER)

    PUMP_RUNAWAY = (70, FaultSite.SUCTION_LINE)
    PUMP_WEAK = (71, FaultSite.SUCTION_LINE)
    PUMP_LOST = (72, FaultSite.SUCTION_LINE)
    REGULATOR_FAILED = (73, FaultSite.SUCTION_LINE)
    RELIEF_FAILED = (74, FaultSite.SUCTION_LINE)
    LINE_LEAK = (75, FaultSite.SUCTION_LINE)
    LINE_CLOGGED = (76, FaultSite.SUCTION_LINE)
    CANISTER_FULL = (77, FaultSite.SUCTION_LINE)

    VACUUM_SENSOR_FROZEN = (80, FaultSite.VACUUM_SENSOR)
    VACUUM_SENSOR_OFFSET = (81, FaultSite.VACUUM_SENSOR)
    VACUUM_SENSOR_NOISY = (82, FaultSite.VACUUM_SENSOR)
    VACUUM_SENSOR_INVALID = (83, FaultSite.VACUUM_SENSOR)

    POWER_LOST = (90, FaultSite.POWER)
    POWER_LOST_WITHOUT_RESERVE = (91, FaultSite.POWER)

    CONTROLLER_STOPPED = (100, FaultSite.CONTROLLER)
    TICK_LATE = (101, FaultSite.CONTROLLER)

    MESSAGE_LATE = (110, FaultSite.MESSAGE)
    MESSAGE_LOST = (111, FaultSite.MESSAGE)
    MESSAGE_REPEATED = (112, FaultSite.MESSAGE)
    READING_LATE = (113, FaultSite.MESSAGE)
    READING_LOST = (114, FaultSite.MESSAGE)
    READING_REPEATED = (115, FaultSite.MESSAGE)

    CIRCUIT_DISCONNECTED = (120, FaultSite.PATIENT)
    VENTILATOR_PRESSURE = (121, FaultSite.PATIENT)
    DESATURATION = (122, FaultSite.PATIENT)
    BRADYCARDIA = (123, FaultSite.PATIENT)
    LUNG_VOLUME_LOST = (124, FaultSite.PATIENT)
    MONITOR_LOST = (125, FaultSite.PATIENT)

    WRONG_PRESET = (140, FaultSite.SETTING)
    CATHETER_TOO_WIDE = (141, FaultSite.SETTING)
    CATHETER_EXPIRED = (142, FaultSite.SETTING)
    TAUGHT_TOO_DEEP = (143, FaultSite.SETTING)

    ENCODER_GLITCH = (150, FaultSite.HEAD_ENCODER)
    ENCODER_DRIFTING = (151, FaultSite.HEAD_ENCODER)
    ENCODER_INTERMITTENT = (152, FaultSite.HEAD_ENCODER)
    ENCODER_ALTERNATING = (153, FaultSite.HEAD_ENCODER)
    CARRIAGE_GLITCH = (154, FaultSite.HEAD_ENCODER)
    CARRIAGE_DRIFTING = (155, FaultSite.HEAD_ENCODER)
    CARRIAGE_INTERMITTENT = (156, FaultSite.HEAD_ENCODER)
    CARRIAGE_ALTERNATING = (157, FaultSite.HEAD_ENCODER)
    HEAD_SENSORS_DRIFTING = (158, FaultSite.HEAD_ENCODER)

    CURRENT_GLITCH = (160, FaultSite.INSERTION_DRIVE)
    CURRENT_PULSE = (161, FaultSite.INSERTION_DRIVE)
    CURRENT_OFFSET = (162, FaultSite.INSERTION_DRIVE)
    CURRENT_NOISY = (163, FaultSite.INSERTION_DRIVE)
    MOTOR_INTERMITTENT = (164, FaultSite.INSERTION_DRIVE)

    CAM_GLITCH = (170, FaultSite.CAM_ENCODER)
    VACUUM_GLITCH = (171, FaultSite.VACUUM_SENSOR)
    VACUUM_SENSOR_DRIFTING = (172, FaultSite.VACUUM_SENSOR)
    CONTACT_GLITCH = (173, FaultSite.SWITCH)
    CONTACT_INTERMITTENT = (174, FaultSite.SWITCH)

    CLAMP_SLIPPING = (180, FaultSite.CATHETER)
    TIP_LEFT_BEHIND = (181, FaultSite.TIP)
    MOUTH_BLIND = (182, FaultSite.TIP)
    MOUTH_DARK = (183, FaultSite.TIP)

    POWER_RETURNING = (190, FaultSite.POWER)
    MESSAGE_INTERMITTENT = (191, FaultSite.MESSAGE)
    READING_INTERMITTENT = (192, FaultSite.MESSAGE)

    MONITOR_FROZEN = (200, FaultSite.PATIENT)
    MONITOR_LATE = (201, FaultSite.PATIENT)
    COUGH = (202, FaultSite.PATIENT)
    DECANNULATION = (203, FaultSite.PATIENT)

    @property
    def title(self) -> str:
        """Its name on the command line and in JSON."""
        return name_of(self)


BY_NAME = {fault.title: fault for fault in Fault}
"""Faults by their name on the command line."""
