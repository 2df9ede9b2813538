"""The driver before object dictionaries that others have published: facts of their EDS files.

- `FAKE_SLAVE`: ROS-Industrial, CIA402VTD, a drive for tests
  (github.com/ros-industrial/ros_canopen, canopen_fake_slaves/config/cia402_slave.eds).
- `IPOS_MODES`: Technosoft, iPOS 1.04, a drive that is sold
  (github.com/ros-industrial/ros_canopen, canopen_402_driver/config/technosoft.eds).
"""

import pytest

from tests.machine.canopen.durand_nodes import (
    DRIVE_OBJECTS,
    I8,
    I16,
    I32,
    U8,
    U16,
    U32,
    Bench,
    Objects,
    virtual_time,
)

FAKE_SLAVE: Objects = {
    (0x6040, 0): (U16, "rw", 0),
    (0x6041, 0): (U16, "ro", 0),
    (0x605A, 0): (I16, "rw", 2),
    (0x605B, 0): (I16, "ro", 0),
    (0x605C, 0): (I16, "ro", 1),
    (0x605D, 0): (I16, "rw", 1),
    (0x605E, 0): (I16, "ro", 2),
    (0x6060, 0): (I8, "rw", 0),
    (0x6061, 0): (I8, "ro", 0),
    (0x6062, 0): (I32, "ro", 0),
    (0x6063, 0): (I32, "ro", 0),
    (0x6064, 0): (I32, "ro", 0),
    (0x6065, 0): (U32, "rw", 0),
    (0x6067, 0): (U32, "rw", 0xFFFFFFFF),
    (0x6068, 0): (U16, "rw", 0),
    (0x606A, 0): (I16, "rw", 0),
    (0x606C, 0): (I32, "ro", 0),
    (0x607A, 0): (I32, "rw", 0),
    (0x607C, 0): (I32, "rw", 0),
    (0x607D, 1): (I32, "rw", -0x80000000),
    (0x607D, 2): (I32, "rw", 0x7FFFFFFF),
    (0x6081, 0): (U32, "rw", 0),
    (0x6082, 0): (U32, "rw", 0),
    (0x6083, 0): (U32, "rw", 0),
    (0x6084, 0): (U32, "rw", 0),
    (0x6085, 0): (U32, "rw", 0),
    (0x608F, 1): (U32, "rw", 0),
    (0x608F, 2): (U32, "ro", 1),
    (0x6098, 0): (I8, "rw", 0),
    (0x6099, 1): (U32, "rw", 0),
    (0x6099, 2): (U32, "rw", 0),
    (0x609A, 0): (U32, "rw", 0),
    (0x60B0, 0): (I32, "rw", 0),
    (0x60B1, 0): (I32, "rw", 0),
    (0x60C2, 1): (U8, "rw", 1),
    (0x60C2, 2): (I8, "rw", -2),
    (0x60F2, 0): (U16, "rw", 0),
    (0x60FD, 0): (U32, "ro", 0),
    (0x60FF, 0): (I32, "rw", 0),
    (0x6502, 0): (U32, "ro", 0xA5),
    (0x67FF, 0): (U32, "ro", 0x40192),
}
"""Its objects of CiA 402; those of CiA 301 are durand's."""

IPOS_MODES = 0x1F0065
"""Object 0x6502: profile position and velocity, homing, interpolated position."""

LACKS = {0x6007: I16, 0x6072: U16, 0x6080: U32, 0x2300: U32}
"""Objects of the first that a drive without a host, or at its limits, cannot do without here."""
COMPLETE: Objects = {
    **FAKE_SLAVE,
    **{(index, 0): (kind, "rw", 0) for index, kind in LACKS.items()},
    (0x6077, 0): (I16, "ro", 0),
}


def test_objects_that_it_cannot_be_driven_without_are_named_and_no_others() -> None:
    with virtual_time():
        said = Bench(FAKE_SLAVE).refusal()
    named = "; ".join(f"object {index:#06x}:00 does not exist" for index in LACKS)
    assert said.endswith(f"node 1 (insertion drive): {named}")


def test_with_these_it_moves() -> None:
    with virtual_time():
        bench = Bench(COMPLETE)
        bench.run_up()
        found = bench.cycle(100, head_mm=25.0, insertion_on=True, valve_on=True)
    assert found.head_mm == pytest.approx(25.0, abs=0.01)
    assert bench.said == []


def test_a_read_only_value_that_is_not_as_it_should_be_is_told() -> None:
    """Fault reaction: the motor runs out instead of being braked."""
    with virtual_time():
        said = Bench({**COMPLETE, (0x605E, 0): (I16, "ro", 0)}).refusal()
    assert said.endswith("node 1 (insertion drive): object 0x605e:00 is read-only")


def test_a_drive_without_cyclic_position_is_refused_before_anything_is_written() -> None:
    with virtual_time():
        bench = Bench({**DRIVE_OBJECTS, (0x6502, 0): (U32, "ro", IPOS_MODES)})
        assert "it has no cyclic synchronous position mode (0x6502)" in bench.refusal()
    asked = [one for one in bench.wire.sent if one.can_id == 0x600 + bench.insertion.number]
    assert asked
    assert all(one.data[0] == 0x40 for one in asked)
