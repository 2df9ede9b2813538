"""Protocol and patient: what is in force, what a draft would do, and other ones set."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request

from opensuction.accounts.rule.right import Right
from opensuction.accounts.session import Session
from opensuction.accounts.site import NotAllowedError
from opensuction.console.access import (
    Here,
    Holder,
    InTurn,
    OutOfTurn,
    allow_change,
    may,
    may_change,
)
from opensuction.console.guard.problem import documented
from opensuction.console.setup import change, protocol_settings
from opensuction.console.setup.form import DraftBody, PatientBody, ProtocolBody
from opensuction.console.setup.protocol_settings import Wanted

router = APIRouter(tags=["Protocol"])

SETS = (Right.CHOOSE_PROTOCOL, Right.CHANGE_LIMITS)
"""One of these whoever sets a protocol must have; which, depends on what is changed."""


def may_set(connection: Request, site: Here, _: InTurn) -> Session:
    """Session of a person who may set something of a protocol; see `access.may_change`."""
    holder = allow_change(site, connection, Right.CHANGE_OWN_PASSWORD)
    if not holder.rights.intersection(SETS):
        raise NotAllowedError(f"{holder.account} may neither choose a protocol nor change limits")
    return holder


@router.get("/protocol", responses=documented(401, 403, 503))
def read_protocol(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]
) -> dict[str, Any]:
    """The protocol in force, its fields with units and ranges, and what else fits the patient."""
    return protocol_settings.shown(site)


@router.post("/protocol/plan", responses=documented(401, 403, 409, 503))
def plan_protocol(
    body: DraftBody,
    site: Here,
    _: OutOfTurn,
    __: Annotated[Holder, Depends(may(Right.SEE_SIGNALS))],
) -> dict[str, Any]:
    """The planner's arithmetic of a draft, and every reason why it cannot be, field by field."""
    return protocol_settings.plan(site, _wanted(body))


@router.put("/protocol", responses=documented(401, 403, 409, 503))
def set_protocol(
    body: ProtocolBody, site: Here, who: Annotated[Session, Depends(may_set)]
) -> dict[str, Any]:
    """Set it on the machine that runs, while that is parked."""
    protocol_settings.put(site, who, _wanted(body), body.version, body.key, body.reason)
    return protocol_settings.shown(site)


def _wanted(body: DraftBody) -> Wanted:
    return Wanted(body.name, body.approach, body.carina, body.protocol)


@router.get("/guidelines", responses=documented(401, 403, 503))
def read_guidelines(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]
) -> list[dict[str, Any]]:
    """Limits of the guidelines by age, each with its source."""
    return protocol_settings.guidelines(change.basis_of(site).site)


@router.get("/patient", responses=documented(401, 403, 503))
def read_patient(
    site: Here, _: Annotated[Holder, Depends(may(Right.SEE_BEDSIDE))]
) -> dict[str, Any]:
    """Data of the patient on which settings depend."""
    return protocol_settings.patient_shown(site)


@router.put("/patient", responses=documented(401, 403, 409, 503))
def set_patient(
    body: PatientBody,
    site: Here,
    who: Annotated[Session, Depends(may_change(Right.CHOOSE_PROTOCOL))],
) -> dict[str, Any]:
    """Another pseudonym; the body that a twin plays cannot be another one."""
    wanted = body.model_dump(exclude={"version", "key"})
    protocol_settings.put_patient(site, who, wanted, body.version, body.key)
    return protocol_settings.patient_shown(site)
