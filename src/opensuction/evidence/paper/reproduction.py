"""The paper reproduced: every table and figure on one page, every number beside its own."""

from collections.abc import Callable
from typing import Any, NamedTuple

from opensuction import __version__
from opensuction.evidence.paper import (
    claim,
    paper_backlash,
    paper_contact,
    paper_identification,
    paper_requirement,
    paper_tracking,
)
from opensuction.evidence.paper.claim import PaperClaim
from opensuction.report.sheet import Section, Sheet, Table
from opensuction.session.plain import without_nan

ORIGINS = (
    "Calibrated: the twin's parameters were chosen so that this number comes out; it says that "
    "the twin is the paper's bench, not that the paper is right. Predicted: nothing was fitted to "
    "it. Computed: follows from the paper's published parameters alone.",
)


class Reproduction(NamedTuple):
    """Everything that ``opensuction reproduce`` shows."""

    claims: list[PaperClaim]
    table1: list[dict[str, Any]]
    table2: list[dict[str, Any]]
    sheet: Sheet


def _claims_table(claims: list[PaperClaim]) -> Table:
    return Table(
        "Every number of the paper beside ours",
        ("claim", "where", "paper", "here", "tolerance", "unit", "origin", "verdict", "remark"),
        tuple(
            (
                entry.name,
                entry.where,
                entry.paper,
                entry.measured,
                entry.tolerance,
                entry.unit,
                entry.origin,
                {"ok": True, "differs": False}.get(entry.verdict, "explained"),
                entry.note if entry.ok else entry.explanation or entry.note,
            )
            for entry in claims
        ),
    )


def _sheet(claims: list[PaperClaim], sections: tuple[Section, ...]) -> Sheet:
    held = sum(entry.ok for entry in claims)
    differing = [entry for entry in claims if entry.verdict == "differs"]
    explained = len(claims) - held - len(differing)
    verdict = f"{held} of {len(claims)} claims hold"
    if explained:
        verdict += f", {explained} explained"
    summary = Section("Claims", ORIGINS, (_claims_table(claims),))
    return Sheet(
        title="The paper reproduced on the digital twin",
        verdict=verdict,
        good=not differing,
        lead="Fig. 5 to Fig. 11 and Tables I and II, in-silico: the bench is a simulated one.",
        run=(("version", __version__), ("machines", "seeds 1 to 5, and the nominal one")),
        sections=(summary, *sections),
    )


def run(tell: Callable[[str], None] = lambda _: None) -> Reproduction:
    """Run everything; some seconds. tell: called with a line of progress before each part."""
    tell("Fig. 5 and 7: the published model and its inverse")
    backlash, on_backlash = paper_backlash.section()
    tell("Fig. 6: identification on the bench")
    identification, on_identification = paper_identification.section()
    tell("Fig. 9 and Table I: known travel length, five machines")
    tracking, on_tracking, table1 = paper_tracking.section()
    tell("Fig. 10, 11 and Table II: contact at three distances, five machines")
    contact, on_contact, table2 = paper_contact.section()
    claims = on_backlash + on_identification + on_tracking + on_contact
    sections = (backlash, identification, tracking, contact, paper_requirement.section())
    return Reproduction(claims, table1, table2, _sheet(claims, sections))


def plain(found: Reproduction, wall_s: float) -> dict[str, Any]:
    """The JSON object of the command."""
    return without_nan(
        {
            "version": __version__,
            "in_silico": True,
            "claims": [claim.plain(entry) for entry in found.claims],
            "table1": found.table1,
            "table2": found.table2,
            "wall_s": wall_s,
        }
    )
