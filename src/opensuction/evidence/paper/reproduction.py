"""The paper reproduced: every table and figure on one page, every number beside its own.

Every number that the paper prints, in its order: held against the twin, set, or why neither.

Left out: numbers of the introduction (patients, hours), references, and axes of figures.

Section II-A and Fig. 8 of the paper: its clinical requirements, and the set-up as a twin.
"""

from collections.abc import Callable, Mapping
from typing import Final, Literal, NamedTuple

from opensuction import __version__
from opensuction.control.compensation import CompensationKind
from opensuction.controller import setup
from opensuction.controller.machine_profile import BENCH
from opensuction.evidence.paper import (
    claim,
    paper_backlash,
    paper_contact,
    paper_identification,
    paper_tracking,
)
from opensuction.evidence.paper.claim import AGREES, DIFFERS, ClaimVerdict, JudgedClaim, PaperClaim
from opensuction.evidence.paper.paper_contact import ContactRow
from opensuction.evidence.paper.paper_tracking import TrackingRow
from opensuction.procedure.planning import clinical
from opensuction.procedure.planning.protocol import BENCH_SITE, PAPER
from opensuction.report.sheet import Cell, Section, Sheet, Table
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


CLAIM: Final = "claim"
SETTING: Final = "set"
ASIDE: Final = "not reproduced"
"""What became of a number: held against ours, a setting of twin or protocol, or neither."""


class PaperNumber(NamedTuple):
    """A number of the paper, or several that belong together."""

    where: str
    what: str
    value: str
    """As printed, with its unit."""
    use: Literal["claim", "set", "not reproduced"]
    why: str
    """The claim's name, what is set by it, or why it is not reproduced."""


MATERIAL = "no geometry of the twin needs it"

NUMBERS: tuple[PaperNumber, ...] = (
    PaperNumber("I", "catheter, and those on the market", "2 m; .4 m", ASIDE, MATERIAL),
    PaperNumber("II-A", "insertion speed", "around 10 mm/s", SETTING, "guideline of speed"),
    PaperNumber("II-A", "tube for adults", "7.5 to 9.5 mm", SETTING, "presets of patients"),
    PaperNumber(
        "II-A", "catheter below half the tube", "8 mm: 4 mm", SETTING, "guideline of ratio"
    ),
    PaperNumber("II-A", "vacuum", "80 to 120, 80 to 100 mmHg", SETTING, "guideline of vacuum"),
    PaperNumber("II-A", "duration of suction", "10 to 15 s, 5 s", SETTING, "guideline of time"),
    PaperNumber("II-A", "depth below the tube", "5 to 10 cm", SETTING, "table of requirements"),
    PaperNumber("II-A", "reuse of a catheter", "24 h", SETTING, "age of a catheter that is used"),
    PaperNumber("II-B", "slide of the valve", "5 mm", SETTING, "valve of the twin"),
    PaperNumber("II-B", "soft tip", "400 mm", ASIDE, MATERIAL),
    PaperNumber("II-B", "catheter", "3.5, 4, 2000 mm", SETTING, "bore and clearance of the twin"),
    PaperNumber("II-B", "conduit", "6, 6.5, 1500 mm", SETTING, "clearance of the twin"),
    PaperNumber("II-B", "pump", "18 L/min, 560 mmHg", SETTING, "pump of the twin"),
    PaperNumber("II-B", "highest vacuum in use", "150 mmHg", SETTING, "relief valve of the bench"),
    PaperNumber("II-B", "least tube", "7.5 mm", SETTING, "table of requirements: it breaks II-A"),
    PaperNumber("II-B", "T-connector", "15 mm, 6.5 mm", ASIDE, MATERIAL),
    PaperNumber(
        "III-B", "Bouc-Wen A, B, m, D, three more", "1.925 ... -7.097", CLAIM, "loop width"
    ),
    PaperNumber("III-B", "beta", ".854", CLAIM, "beta"),
    PaperNumber("III-B", "alpha_0", ".077", CLAIM, "alpha_0"),
    PaperNumber("III-B", "c", ".9677", CLAIM, "c"),
    PaperNumber("III-B", "y_0", "-7.151", CLAIM, "y_0"),
    PaperNumber("III-B", "RMSE of Bouc-Wen", ".8009 mm", CLAIM, "RMSE of the Bouc-Wen model"),
    PaperNumber("III-B", "RMSE of modified Dahl", ".8301 mm", CLAIM, "RMSE of the modified Dahl"),
    PaperNumber(
        "III-B", "a slight difference of the two", ".8009, .8301", CLAIM, "RMSE of Bouc-Wen over"
    ),
    PaperNumber("III-B", "parameters of the models", "six, four", ASIDE, "the text lists seven"),
    PaperNumber("III-D", "elastomer, wires", ".1 mm, .2 mm", ASIDE, MATERIAL),
    PaperNumber("III-D", "signal of the switch", "2 V", ASIDE, "a contact is read as a bit"),
    PaperNumber("IV-A", "gains of motor A", "P = 10, D = 10", SETTING, "no units are printed"),
    PaperNumber("IV-A", "gains of motor B", "P = 7, D = 7", SETTING, "no units are printed"),
    PaperNumber("IV-A", "speed both ways", "around 1 cm/s", SETTING, "protocol paper: 9 mm/s"),
    PaperNumber("IV-A", "standing for suction", "5 to 10 s", SETTING, "protocol paper: 9 s"),
    PaperNumber("IV-A", "cam", "30 degrees at 15/s", SETTING, "valve of the bench"),
    PaperNumber("IV-B", "travel, speed, suction", "90 mm, 9 mm/s, 9 s", SETTING, "protocol paper"),
    PaperNumber("IV-B", "RMSE of the trial shown", "15.413, 2.4578 mm", CLAIM, "Table I, trial 1"),
    PaperNumber("Table I", "ten RMSE", "14.998 ... 2.2243 mm", CLAIM, "means and scatter"),
    PaperNumber("IV-C", "speed of the contact trials", "9 mm/s", SETTING, "protocol paper"),
    PaperNumber("IV-C", "distances of the carina", "65, 55, 45 mm", SETTING, "of the trials"),
    PaperNumber("IV-C", "force that closes the switch", ".08017 N", CLAIM, "force at which"),
    PaperNumber("IV-C", "trials, suctions completed", "5 each, all", CLAIM, "suctions completed"),
    PaperNumber("Table II", "15 stops", "64.782 ... 44.988 mm", CLAIM, "stop errors"),
    PaperNumber("IV-C", "mean stop errors", ".4076, .2626, .3862 mm", CLAIM, "mean stop error"),
    PaperNumber("V", "size of the catheter", "around 4 mm", SETTING, "as II-B"),
    PaperNumber(
        "V", "identification", "around 3 min", ASIDE, "another algorithm, on another processor"
    ),
)


KINDS = (
    "Printed: the paper prints the number; computed: it follows from numbers that it prints. "
    "Calibrated: the twin's parameters were chosen so that this number comes out, which says that "
    "the twin is like the paper's bench, not that the paper is right. Predicted: nothing was "
    "fitted to it. Arithmetic: no twin takes part.",
    "Tolerances come from standard errors, of the paper's trials and of ours: the difference that "
    "chance exceeds in one case of twenty. Agreement is evidence only where the number was "
    "predicted, and where a measurement of nothing (no error, no compensator, no scatter) would "
    "not have passed as well.",
)


class Reproduction(NamedTuple):
    """Everything that ``opensuction reproduce`` shows."""

    claims: list[PaperClaim]
    table1: tuple[TrackingRow, ...]
    table2: tuple[ContactRow, ...]
    sheet: Sheet


class ReproductionResult(NamedTuple):
    """Claims and tables of the paper beside ours."""

    version: str
    """Of the software."""
    in_silico: bool
    claims: tuple[JudgedClaim, ...]
    verdicts: Mapping[ClaimVerdict, int]
    """Number of claims of each."""
    table1: tuple[TrackingRow, ...]
    table2: tuple[ContactRow, ...]
    numbers: tuple[PaperNumber, ...]
    wall_s: float
    """Duration of the command."""


def _claims_table(claims: list[PaperClaim]) -> Table:
    return Table(
        "The paper's numbers beside ours",
        (
            "claim",
            "where",
            "source",
            "kind",
            "paper",
            "here",
            "standard error",
            "tolerance",
            "unit",
            "verdict",
            "remark",
        ),
        tuple(
            (
                entry.name,
                entry.where,
                entry.source,
                entry.kind,
                entry.paper,
                entry.measured,
                entry.standard_error,
                entry.tolerance,
                entry.unit,
                Cell(entry.verdict, _colour(entry)),
                _remark(entry),
            )
            for entry in claims
        ),
    )


def _colour(entry: PaperClaim) -> str:
    if entry.is_unexplained:
        return "bad"
    return {AGREES: "good", DIFFERS: "notice"}.get(entry.verdict, "")


def _remark(entry: PaperClaim) -> str:
    if not entry.ok:
        return entry.explanation or entry.note
    return "; ".join(part for part in (entry.why_no_evidence, entry.note) if part)


def _numbers_table() -> Table:
    return Table(
        "What the paper prints, line by line, and what became of it",
        ("where", "what", "value", "use", "by"),
        tuple(tuple(number) for number in NUMBERS),
    )


def _sheet(claims: list[PaperClaim], sections: tuple[Section, ...]) -> Sheet:
    unexplained = [entry for entry in claims if entry.is_unexplained]
    summary = Section("Claims", KINDS, (_claims_table(claims),))
    numbers = Section("Every number of the paper", (), (_numbers_table(),), anchor="numbers")
    return Sheet(
        title="The paper reproduced on the digital twin",
        verdict=f"{len(claims)} claims: {claim.counted(claim.tally(claims))}",
        good=not unexplained,
        lead="Fig. 5 to Fig. 11 and Tables I and II, in-silico: the bench is a simulated one.",
        run=(
            ("version", __version__),
            ("machines", "seeds 1 to 5 for Table I, 1 to 15 for Table II, and the nominal one"),
        ),
        sections=(summary, *sections, numbers),
        kind="" if unexplained else "notice",
    )


def run(tell: Callable[[str], None] = lambda _: None) -> Reproduction:
    """Run everything; some seconds. tell: called with a line of progress before each part."""
    tell("Fig. 5 and 7: the published model and its inverse")
    backlash, on_backlash = paper_backlash.section()
    tell("Fig. 6: identification on the bench, and of other plants")
    identification, on_identification = paper_identification.section()
    tell("Fig. 9 and Table I: known travel length, five machines")
    tracking, on_tracking, table1 = paper_tracking.section()
    tell("Fig. 10, 11 and Table II: contact at three distances, 15 machines")
    contact, on_contact, table2 = paper_contact.section()
    claims = on_backlash + on_identification + on_tracking + on_contact
    sections = (backlash, identification, tracking, contact, section())
    return Reproduction(claims, table1, table2, _sheet(claims, sections))


def to_result(found: Reproduction, wall_s: float) -> ReproductionResult:
    """The result of the command."""
    return ReproductionResult(
        version=__version__,
        in_silico=True,
        claims=tuple(claim.judge(entry) for entry in found.claims),
        verdicts=claim.tally(found.claims),
        table1=found.table1,
        table2=found.table2,
        numbers=NUMBERS,
        wall_s=wall_s,
    )
