"""Identification of the machine's kind before use, and its acceptance by an engineer."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path

from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session
from opensuction.console.access import Here, Holder, check_reason, may, may_change
from opensuction.console.guard.problem import documented
from opensuction.console.setup import acceptance, bedside, change, machine_identification
from opensuction.console.setup.form import ReasonBody

router = APIRouter(tags=["Identification"])

Id = Annotated[str, Path(max_length=40)]


@router.get("/identification", responses=documented(401, 403, 503))
def read_identification(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_SIGNALS))]
) -> dict[str, Any]:
    """Source of the machine's settings, and the runs of this console."""
    found = bedside.basis_of(site)
    return {
        "version": found.version,
        "calibrated_by": found.calibrated_by,
        "compensation": found.compensation.name.lower().replace("_", "-"),
        "is_bench": found.person is None,
        "measured": machine_identification.MEASURED,
        "runs": [acceptance.shown(site, one) for one in machine_identification.RUNS.list()[:1]],
    }


@router.post("/identification", status_code=202, responses=documented(401, 403, 409, 503))
def begin_identification(
    body: ReasonBody, site: Here, who: Annotated[Session, Depends(may_change(Right.CALIBRATE))]
) -> dict[str, Any]:
    """Excite a simulated machine of this kind; the one at the bed is not moved."""
    reason = check_reason(body.reason)
    found = bedside.basis_of(site)
    detail = f"a simulated machine of this kind; reason: {reason}"
    change.record(site, who.account, "identify-kind", detail, body.key)
    return acceptance.shown(site, machine_identification.RUNS.begin(site, who, found))


@router.get("/identification/{run}", responses=documented(401, 403, 404))
def read_run(
    run: Id, site: Here, _: Annotated[Holder, Depends(may(Right.SEE_SIGNALS))]
) -> dict[str, Any]:
    """Progress and result of a run, with the loop of head and tip."""
    return acceptance.shown(site, machine_identification.RUNS.find(run))


@router.post("/identification/{run}/accept", responses=documented(401, 403, 404, 409, 503))
def accept_run(
    run: Id,
    body: ReasonBody,
    site: Here,
    who: Annotated[Session, Depends(may_change(Right.CALIBRATE))],
) -> dict[str, Any]:
    """Have the machine at the bed go by what was found, while it is parked."""
    reason = check_reason(body.reason)
    found = machine_identification.RUNS.find(run)
    acceptance.accept(site, who, found, reason, body.version, body.key)
    return acceptance.shown(site, found)
