"""Identification of the machine's kind before use, and its acceptance by an engineer.

Teaching the travel length, and the catheter's change.
"""

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path

from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session
from opensuction.console.access import Here, Holder, check_reason, may, may_change
from opensuction.console.guard.problem import documented
from opensuction.console.setup import change, machine_identification, teach
from opensuction.console.setup.form import CatheterBody, ReasonBody, TeachingBody

teaching_router = APIRouter(tags=["Teaching"])


@teaching_router.get("/teaching", responses=documented(401, 403, 503))
def read_teaching(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]
) -> dict[str, Any]:
    """State of teaching, the steps that it allows, and the length that was taught."""
    return teach.shown(site)


@teaching_router.post("/teaching", responses=documented(401, 403, 409, 503))
def step_teaching(
    body: TeachingBody, site: Here, who: Annotated[Session, Depends(may_change(Right.TEACH))]
) -> dict[str, Any]:
    """Take a step; to stop at any of them, press Stop."""
    teach.take_step(site, who, body.step, body.version, body.key)
    return teach.shown(site)


@teaching_router.get("/catheter", responses=documented(401, 403, 503))
def read_catheter(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]
) -> dict[str, Any]:
    """The catheter that is in, and how long it may still be used."""
    return teach.shown_catheter(site)


@teaching_router.put("/catheter", responses=documented(401, 403, 409, 503))
def change_catheter(
    body: CatheterBody,
    site: Here,
    who: Annotated[Session, Depends(may_change(Right.CHANGE_CATHETER))],
) -> dict[str, Any]:
    """Say that another one has been put in, while the machine is out of service."""
    teach.put(site, who, body.label, body.key)
    return teach.shown_catheter(site)


router = APIRouter(tags=["Identification"])

Id = Annotated[str, Path(max_length=40)]


@router.get("/identification", responses=documented(401, 403, 503))
def read_identification(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_SIGNALS))]
) -> dict[str, Any]:
    """Source of the machine's settings, and the runs of this console."""
    found = change.basis_of(site)
    return {
        "version": found.version,
        "calibrated_by": found.calibrated_by,
        "compensation": found.compensation.name.lower().replace("_", "-"),
        "is_bench": found.person is None,
        "measured": machine_identification.MEASURED,
        "runs": [
            machine_identification.shown_acceptance(site, one)
            for one in machine_identification.RUNS.list()[:1]
        ],
    }


@router.post("/identification", status_code=202, responses=documented(401, 403, 409, 503))
def begin_identification(
    body: ReasonBody, site: Here, who: Annotated[Session, Depends(may_change(Right.CALIBRATE))]
) -> dict[str, Any]:
    """Excite a simulated machine of this kind; the one at the bed is not moved."""
    reason = check_reason(body.reason)
    machine_identification.check_simulated(site)
    found = change.basis_of(site)
    detail = f"a simulated machine of this kind; reason: {reason}"
    change.record(site, who.account, "identify-kind", detail, body.key)
    return machine_identification.shown_acceptance(
        site, machine_identification.RUNS.begin(site, who, found)
    )


@router.get("/identification/{run}", responses=documented(401, 403, 404))
def read_run(
    run: Id, site: Here, _: Annotated[Holder, Depends(may(Right.SEE_SIGNALS))]
) -> dict[str, Any]:
    """Progress and result of a run, with the loop of head and tip."""
    return machine_identification.shown_acceptance(site, machine_identification.RUNS.find(run))


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
    machine_identification.accept(site, who, found, reason, body.version, body.key)
    return machine_identification.shown_acceptance(site, found)
