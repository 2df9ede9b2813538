"""Teaching the travel length, and the catheter's change."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends

from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session
from opensuction.console.access import Here, Holder, may, may_change
from opensuction.console.guard.problem import documented
from opensuction.console.setup import catheter, teach
from opensuction.console.setup.form import CatheterBody, TeachingBody

router = APIRouter(tags=["Teaching"])


@router.get("/teaching", responses=documented(401, 403, 503))
def read_teaching(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]
) -> dict[str, Any]:
    """State of teaching, the steps that it allows, and the length that was taught."""
    return teach.shown(site)


@router.post("/teaching", responses=documented(401, 403, 409, 503))
def step_teaching(
    body: TeachingBody, site: Here, who: Annotated[Session, Depends(may_change(Right.TEACH))]
) -> dict[str, Any]:
    """Take a step; to stop at any of them, press Stop."""
    teach.take_step(site, who, body.step, body.version, body.key)
    return teach.shown(site)


@router.get("/catheter", responses=documented(401, 403, 503))
def read_catheter(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]
) -> dict[str, Any]:
    """The catheter that is in, and how long it may still be used."""
    return catheter.shown(site)


@router.put("/catheter", responses=documented(401, 403, 409, 503))
def change_catheter(
    body: CatheterBody,
    site: Here,
    who: Annotated[Session, Depends(may_change(Right.CHANGE_CATHETER))],
) -> dict[str, Any]:
    """Say that another one has been put in, while the machine is out of service."""
    catheter.put(site, who, body.label, body.key)
    return catheter.shown(site)
