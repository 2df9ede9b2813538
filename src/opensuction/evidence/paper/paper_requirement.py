"""Section II-A and Fig. 8 of the paper: its clinical requirements, and the set-up as a twin."""

from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.controller.machine_profile import BENCH
from opensuction.procedure.planning import clinical
from opensuction.procedure.planning.protocol import PAPER
from opensuction.procedure.planning.site import BENCH_SITE
from opensuction.report.sheet import Section, Table
from opensuction.simulation import rig as rigs

DEPTH_MM = (50.0, 100.0)
"""Insertion depth below the tube that the paper asks for."""
TUBE_MM = 7.5
"""Smallest tube that the paper allows for its 4 mm catheter (section II-B)."""
CATHETER_MM = 4.0

SETUP = (
    ("motor A, gear, linear guide", "DC axis with friction, current limit, encoder, gear backlash"),
    ("catheter in its conduit", "distributed play, friction-limited stretch, creep"),
    ("motor B, cam, valve, spring", "DC axis against a spring, seal and slide of the valve"),
    ("suction pump 18 L/min, 560 mmHg", "pump, regulator, relief, canister, turbulent bore"),
    ("rubber trachea", "secretions along it, an elastic carina at its end"),
    ("sensing device at the tip", "switch with threshold, bounce and latency; buckling tip"),
    ("laser LK-G402", "displacement of the tip with noise; never read by the controller"),
    ("force sensor LSB200", "the contact force itself"),
)
"""Fig. 8: what stands on the paper's bench, and what takes its place."""


def section() -> Section:
    """Section on the paper's own requirements, kept or not, and on the set-up of Fig. 8."""
    able = setup.abilities(BENCH, CompensationKind.NONE, rigs.uncalibrated(BENCH), BENCH_SITE)
    found = clinical.held_against_guidelines(PAPER, able, BENCH_SITE, by_contact=False)
    rows = [(check.name, check.value, check.limit, check.unit, check.ok) for check in found]
    low, high = DEPTH_MM
    depth_ok = low <= PAPER.travel_mm <= high
    rows.append(("depth below the tube, 50 to 100", PAPER.travel_mm, high, "mm", depth_ok))
    ratio = CATHETER_MM / TUBE_MM
    rows.append((f"catheter over a {TUBE_MM:g} mm tube", ratio, 0.5, "", ratio < 0.5))
    text = (
        "The paper's cycle keeps suction on through dwell and withdrawal, about 21 s, which is "
        "longer than its own 10 to 15 s: the protocol `paper` is therefore for the bench only. "
        f"It allows tubes from {TUBE_MM:g} mm, where a 4 mm catheter fills {ratio:.2f} of the "
        "diameter and its own rule asks for less than half: 8.5 mm and more keep it.",
    )
    tables = (
        Table(
            "Requirements of section II-A",
            ("requirement", "value", "limit", "unit", "met"),
            tuple(rows),
        ),
        Table("Fig. 8: the set-up", ("on the paper's bench", "in the twin"), SETUP),
    )
    return Section("Clinical requirements and set-up (section II-A, Fig. 8)", text, tables)
