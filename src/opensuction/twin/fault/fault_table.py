"""Every fault that can be injected: one row each, in the file of its part of the machine."""

from opensuction.twin.fault import (
    contact_fault,
    insertion_fault,
    link_fault,
    patient_fault,
    setup_fault,
    suction_fault,
    valve_fault,
)
from opensuction.twin.fault.fault import Fault
from opensuction.twin.fault.fault_row import FaultRow

ROWS: dict[Fault, FaultRow] = {
    fault: part(fault)
    for rows in (
        contact_fault.ROWS,
        insertion_fault.ROWS,
        valve_fault.ROWS,
        suction_fault.ROWS,
        link_fault.ROWS,
        patient_fault.ROWS,
        setup_fault.ROWS,
    )
    for fault, part in rows.items()
}
"""Rows by fault. Their order counts: campaigns draw a fault by its place here."""
