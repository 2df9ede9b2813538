"""The patient at the machine, as far as the machine's settings depend on it."""

from typing import Any

from opensuction.accounts.session import Session
from opensuction.console.guard.problem import FieldError, Problem
from opensuction.console.setup import bedside, change
from opensuction.console.site import ConsoleContext
from opensuction.kernel.errors import InputError
from opensuction.records import entry_check
from opensuction.runtime import machine_identity
from opensuction.runtime.machine_identity import About
from opensuction.session.running import basis as bases
from opensuction.session.running.basis import Basis

FIXED_ON_TWIN = (
    "the twin plays one patient for as long as it runs: for another one end it, and start it with "
    "opensuction serve --patient"
)
FIXED = (
    "the machine's settings are made for one body: for another one end it, and prepare it anew for "
    "that one"
)
NOBODY = "nobody is on this machine: a bench has no patient"


def shown(site: ConsoleContext) -> dict[str, Any]:
    """The patient."""
    found, told = bedside.basis_of(site), site.about()
    geometry, person = found.site, found.person
    return {
        "version": found.version,
        "is_twin": told.machine.is_twin,
        "is_bench": person is None,
        "pseudonym": told.patient,
        "age": geometry.age.name.lower(),
        "tube_mm": geometry.tube_mm,
        "tube_length_mm": None if person is None else person.tube_length_mm,
        "weight_kg": None if person is None else person.weight_kg,
        "catheter_mm": geometry.catheter_mm,
        "carina_mm": geometry.carina_mm,
        "peep_cmh2o": geometry.peep_cmh2o,
        "fixed": _why_fixed(told) if person is not None else NOBODY,
    }


def put(site: ConsoleContext, who: Session, wanted: dict[str, Any], version: int, key: str) -> None:
    """Another pseudonym; another body is refused. Raises Problem."""
    with change.LOCK:
        found, now = bedside.basis_of(site), bedside.now(site)
        change.check_version(found, version)
        bedside.require_parked(now)
        told = site.about()
        if found.person is None:
            raise Problem(409, NOBODY)
        _refuse_other(found, wanted, _why_fixed(told))
        pseudonym = wanted["pseudonym"]
        try:
            entry_check.check_pseudonym(pseudonym)
        except InputError as error:
            raise Problem(422, str(error), [FieldError("pseudonym", str(error))]) from None
        if pseudonym == told.patient:
            raise Problem(409, "nothing would be other than it is")
        detail = f"pseudonym {told.patient} -> {pseudonym}"
        change.record(site, who.account, "choose-patient", detail, key)
        machine_identity.write(site.folder, told._replace(patient=pseudonym))
        bases.write(site.folder, found._replace(version=found.version + 1))


def _why_fixed(told: About) -> str:
    """Reason why nobody else can be chosen here."""
    return FIXED_ON_TWIN if told.machine.is_twin else FIXED


def _refuse_other(found: Basis, wanted: dict[str, Any], why: str) -> None:
    """Raises Problem for another body than the one at the machine. why: it cannot be another."""
    assert found.person is not None
    is_there = {
        "age": found.site.age.name.lower(),
        "tube_mm": found.site.tube_mm,
        "weight_kg": found.person.weight_kg,
    }
    other = [
        FieldError(name, why)
        for name, value in is_there.items()
        if wanted.get(name) is not None and wanted[name] != value
    ]
    if other:
        raise Problem(409, why, other)
