"""Teaching the travel length, a step at a time.

The machine gets limits under which a person may push the catheter to the carina, and no cycle
starts; it is taught; then either the clinical protocol is fitted to what was taught, or what was in
force before is set again. Where a machine has a simulated hand, as a twin, that one pushes.

The catheter: how long it may still be used, and which one takes its place.

Its life begins on record with its first cycle; in the controller when it is put in.
"""

import contextlib
import time
from enum import StrEnum
from typing import Any

from opensuction.accounts.session import Session
from opensuction.console.access import ConsoleContext
from opensuction.console.guard.problem import FieldError, Problem
from opensuction.console.setup import change, draft
from opensuction.console.setup.change import Now, SettingsChange
from opensuction.controller import configuration
from opensuction.kernel.errors import InputError
from opensuction.kernel.vocabulary import Phase
from opensuction.machine import port
from opensuction.machine.port import Capabilities, HandTask, SimulatedHand
from opensuction.procedure.cycle.teaching import PLAUSIBLE
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.records import entry
from opensuction.runtime import machine_folder
from opensuction.session.running.basis import Basis

NEW_S = 5.0
"""A catheter that is younger has just been put in."""
SEEN_S = 1.0
"""How long the controller's next rows may take to show it."""


def shown_catheter(site: ConsoleContext) -> dict[str, Any]:
    """The catheter that is in."""
    now, told = change.now(site), site.about().catheter
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
        now, told = change.now(site), site.about()
        if now.phase != Phase.OUT_OF_SERVICE:
            raise Problem(
                409, "take the machine out of service first: nothing may move with hands at it"
            )
        _check_label(site, label)
        detail = f"{told.catheter.label} -> {label}, {told.catheter.size_fr} Fr"
        change.record(site, who.account, "change-catheter", detail, key)
        change.press(site.folder, "changed", who.account, key)
        ends_s = time.monotonic() + SEEN_S
        while change.now(site).catheter_age_s > NEW_S:
            if time.monotonic() > ends_s:
                raise Problem(409, "the controller did not take it: is it out of service?")
            time.sleep(0.01)
        machine_folder.write(
            site.folder, told._replace(catheter=told.catheter._replace(label=label))
        )


def _check_label(site: ConsoleContext, label: str) -> None:
    """Raises Problem for what is no label, and for one that another catheter has had."""
    try:
        entry.check_name("the catheter's label", label)
    except InputError as error:
        raise Problem(422, str(error), [FieldError("label", str(error))]) from None
    if label == site.about().catheter.label or site.records.catheter_age_s(label) is not None:
        words = f"a catheter '{label}' has been used already: each one has a label of its own"
        raise Problem(409, words, [FieldError("label", words)])


OWN_HAND = "a person's own hand moves this machine"
NO_HAND = "no hand can move this machine's catheter head: set the length that somebody has measured"
BENCH = "a bench has no carina to be taught: its protocol names its own travel"


class Step(StrEnum):
    """Step of teaching that a person asks for."""

    PREPARE = "prepare"
    """Set the limits under which a person pushes."""
    BEGIN = "begin"
    """Let the head be moved by hand."""
    CONFIRM = "confirm"
    """The tip is at the carina."""
    HOME = "home"
    """The drive shall bring the head home."""
    PUSH = "push"
    """The simulated hand pushes until it feels the carina."""
    DRAW = "draw"
    """It draws the catheter back."""
    TAKE = "take"
    """Fit the protocol to what was taught."""
    LEAVE = "leave"
    """Set again what was in force before."""


class Stage(StrEnum):
    """Stage of teaching."""

    IDLE = "idle"
    PREPARED = "prepared"
    MOVING = "moving"
    """A person moves the head."""
    HOMING = "homing"
    TAUGHT = "taught"
    """A length was taken, and the head is home."""
    BUSY = "busy"
    """The machine does something else."""


BUTTONS = {Step.BEGIN: "teach", Step.CONFIRM: "confirm", Step.HOME: "home"}
HANDS = {Step.PUSH: HandTask.PUSH, Step.DRAW: HandTask.DRAW}
ALLOWED = {
    Stage.IDLE: (Step.PREPARE,),
    Stage.PREPARED: (Step.BEGIN, Step.LEAVE),
    Stage.MOVING: (Step.CONFIRM, Step.HOME, Step.PUSH, Step.DRAW),
    Stage.HOMING: (),
    Stage.TAUGHT: (Step.TAKE, Step.BEGIN, Step.LEAVE),
    Stage.BUSY: (),
}
"""Steps that a stage allows; to stop is always allowed, and another request."""


def stage_of(found: Basis, now: Now) -> Stage:
    """Stage of teaching, by the machine's phase and settings."""
    if now.phase == Phase.TEACHING:
        return Stage.HOMING if now.is_bringing else Stage.MOVING
    if now.phase != Phase.PARKED:
        return Stage.BUSY
    if not found.is_teaching:
        return Stage.IDLE
    return Stage.PREPARED if now.taught_mm is None else Stage.TAUGHT


def shown(site: ConsoleContext) -> dict[str, Any]:
    """Stage of teaching, and the length that was taught."""
    found, now = change.basis_of(site), change.now(site)
    span, can = PLAUSIBLE[found.site.age], site.hub.machine().capabilities
    stage = stage_of(found, now)
    return {
        "version": found.version,
        "stage": str(stage),
        "is_prepared": found.is_teaching,
        "steps": [str(one) for one in ALLOWED[stage] if _why_not(one, can) is None],
        "phase": now.phase_name,
        "is_twin": site.about().machine.is_twin,
        "is_bench": found.person is None,
        "carina_mm": found.site.carina_mm,
        "taught_by": found.taught_by,
        "least_mm": span.least_mm,
        "most_mm": span.most_mm,
        "result": now.taught.name.lower().replace("_", "-"),
        "sentence": now.taught_sentence,
        "taught_mm": now.taught_mm,
        "is_away": now.is_away,
        "feels": _feels(site) if stage == Stage.MOVING else None,
        "head_mm": now.head_mm,
        "inside_s": now.inside_s,
        "inside_most_s": GUIDELINES[found.site.age].in_airway_s,
    }


def _why_not(step: Step, can: Capabilities) -> str | None:
    """Reason why a machine cannot take a step; None where it can."""
    if step in HANDS and not can.simulated_hand:
        return OWN_HAND
    if step in (Step.PREPARE, Step.BEGIN) and not can.taught_by_hand:
        return NO_HAND
    return None


def _hand(site: ConsoleContext) -> SimulatedHand | None:
    """The hand at the catheter head that software moves; None of a machine that has none."""
    if not site.hub.machine().capabilities.simulated_hand:
        return None
    try:
        return port.load(site.folder).hand_of(site.folder)
    except InputError:
        return None


def _feels(site: ConsoleContext) -> bool | None:
    """True while a simulated hand feels the carina; None where there is none, or none says."""
    hand = _hand(site)
    return None if hand is None else hand.feels_carina()


def take_step(site: ConsoleContext, who: Session, step: Step, version: int, key: str) -> None:
    """Carry a step out. Raises Problem, InputError or RecordsError; then nothing was done."""
    with change.LOCK:
        found, now = change.basis_of(site), change.now(site)
        stage = stage_of(found, now)
        if found.person is None:
            raise Problem(409, BENCH)
        if step not in ALLOWED[stage]:
            raise Problem(
                409,
                f"'{step}' means nothing now: the machine is {now.phase_name}, and teaching "
                f"is {stage}",
            )
        if (why := _why_not(step, site.hub.machine().capabilities)) is not None:
            raise Problem(409, why)
        if step in HANDS:
            _hold(site, found, HANDS[step])
            return
        if step in BUTTONS:
            _put_hand_away(site, found, step)
            change.press(site.folder, BUTTONS[step], who.account, key)
            if step == Step.CONFIRM and _hand(site) is not None:
                # It presses on the carina no longer than it must: the governor allows 2 s.
                _hold(site, found, HandTask.DRAW)
            return
        change.check_version(found, version)
        change.carry_out(site, _change(found, now, who, step, key))


def _change(found: Basis, now: Now, who: Session, step: Step, key: str) -> SettingsChange:
    """Other settings for a step. Raises InputError for a length that no protocol fits."""
    if step == Step.PREPARE:
        detail = "limits to teach with; no cycle starts"
        return SettingsChange(
            who.account, key, "prepare-teaching", detail, found._replace(is_teaching=True)
        )
    if step == Step.LEAVE:
        detail = f"{found.protocol_name} again, carina at {found.site.carina_mm:.1f} mm"
        return SettingsChange(
            who.account, key, "leave-teaching", detail, found._replace(is_teaching=False)
        )
    following = _taught(found, now, who)
    detail = (
        f"carina at {following.site.carina_mm:.1f} mm, before {found.site.carina_mm:.1f}; travel "
        f"{following.protocol.travel_mm:.1f} mm, before {found.protocol.travel_mm:.1f}"
    )
    return SettingsChange(who.account, key, "take-taught-length", detail, following)


def _taught(found: Basis, now: Now, who: Session) -> Basis:
    """With the clinical protocol as it fits what was taught; one of its own numbers is kept."""
    assert now.taught_mm is not None
    geometry = found.site._replace(carina_mm=now.taught_mm)
    following = found._replace(
        site=geometry, is_teaching=False, taught_by=f"taught by {who.account}"
    )
    fitted = draft.fitted(found, geometry, found.by_contact)
    own = fitted.get(found.template or next(iter(fitted), ""))
    if isinstance(own, str) or own is None:
        raise Problem(422, own or "no clinical protocol is for this patient")
    name = found.template or next(iter(fitted))
    checked = draft.Draft(found.by_contact, geometry, own, ())
    if refused := draft.judge(found, checked):
        raise Problem(422, refused[0].sentence)
    return following._replace(protocol=own, protocol_name=name, template=name)


def _hold(site: ConsoleContext, found: Basis, task: HandTask) -> None:
    """The simulated hand does something."""
    hand = _hand(site)
    if hand is None:
        raise Problem(409, OWN_HAND)
    try:
        text = (site.folder / machine_folder.CONFIGURATION).read_text(encoding="utf-8")
        park_mm = configuration.from_json(text).settings.parked.head_mm
        hand.hold(task, park_mm, -found.site.park_mm)
    except (InputError, OSError) as error:
        raise Problem(503, f"the machine's hand does not answer: {error}") from None


def _put_hand_away(site: ConsoleContext, found: Basis, step: Step) -> None:
    """A drive that brings the head home, or another teaching, meets no hand of the one before."""
    if step != Step.CONFIRM and _hand(site) is not None:
        with contextlib.suppress(Problem):
            _hold(site, found, HandTask.LET_GO)
