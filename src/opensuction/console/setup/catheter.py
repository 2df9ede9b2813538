"""The catheter: how long it may still be used, and which one takes its place.

Its life begins on record with its first cycle; in the controller when it is put in.
"""

import time
from typing import Any

from opensuction.accounts.session import Session
from opensuction.console.guard.problem import FieldError, Problem
from opensuction.console.setup import bedside, change
from opensuction.console.site import ConsoleContext
from opensuction.kernel.errors import InputError
from opensuction.kernel.phase import Phase
from opensuction.records import entry_check
from opensuction.runtime import machine_identity

NEW_S = 5.0
"""A catheter that is younger has just been put in."""
SEEN_S = 1.0
"""How long the controller's next rows may take to show it."""


def shown(site: ConsoleContext) -> dict[str, Any]:
    """The catheter that is in."""
    now, told = bedside.now(site), site.about().catheter
    used_s = site.records.catheter_age_s(told.label)
    return {
        "label": told.label,
        "size_fr": told.size_fr,
        "life_s": told.life_s,
        "age_s": now.catheter_age_s if now.catheter_age_s < float("inf") else None,
        "left_s": max(told.life_s - now.catheter_age_s, 0.0),
        "first_use_s_ago": used_s,
        "phase": now.phase_name,
        "is_out_of_service": now.phase == Phase.OUT_OF_SERVICE,
    }


def put(site: ConsoleContext, who: Session, label: str, key: str) -> None:
    """Say that another one has been put in. Raises Problem, or RecordsError: nothing was changed.

    The machine must be out of service: hands are at it, and nothing moves.
    """
    with change.LOCK:
        now, told = bedside.now(site), site.about()
        if now.phase != Phase.OUT_OF_SERVICE:
            raise Problem(
                409, "take the machine out of service first: nothing may move with hands at it"
            )
        _check_label(site, label)
        detail = f"{told.catheter.label} -> {label}, {told.catheter.size_fr} Fr"
        change.record(site, who.account, "change-catheter", detail, key)
        bedside.press(site.folder, "changed", who.account, key)
        ends_s = time.monotonic() + SEEN_S
        while bedside.now(site).catheter_age_s > NEW_S:
            if time.monotonic() > ends_s:
                raise Problem(409, "the controller did not take it: is it out of service?")
            time.sleep(0.01)
        machine_identity.write(
            site.folder, told._replace(catheter=told.catheter._replace(label=label))
        )


def _check_label(site: ConsoleContext, label: str) -> None:
    """Raises Problem for what is no label, and for one that another catheter has had."""
    try:
        entry_check.check_name("the catheter's label", label)
    except InputError as error:
        raise Problem(422, str(error), [FieldError("label", str(error))]) from None
    if label == site.about().catheter.label or site.records.catheter_age_s(label) is not None:
        words = f"a catheter '{label}' has been used already: each one has a label of its own"
        raise Problem(409, words, [FieldError("label", words)])
