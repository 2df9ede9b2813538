"""The paper reproduced: every table and figure on one page, every number beside its own."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from opensuction import __version__
from opensuction.evidence.paper import (
    claim,
    paper_backlash,
    paper_contact,
    paper_identification,
    paper_numbers,
    paper_requirement,
    paper_tracking,
)
from opensuction.evidence.paper.claim import AGREES, DIFFERS, ClaimVerdict, JudgedClaim, PaperClaim
from opensuction.evidence.paper.paper_contact import ContactRow
from opensuction.evidence.paper.paper_numbers import PaperNumber
from opensuction.evidence.paper.paper_tracking import TrackingRow
from opensuction.report.sheet import Cell, Section, Sheet, Table

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
        tuple(tuple(number) for number in paper_numbers.NUMBERS),
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
    sections = (backlash, identification, tracking, contact, paper_requirement.section())
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
        numbers=paper_numbers.NUMBERS,
        wall_s=wall_s,
    )
