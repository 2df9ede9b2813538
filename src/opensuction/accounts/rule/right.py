"""Rights of each role: one table, which the API enforces and the page shows.

Source of the roles: [design] everybody may stop; only a clinician starts; only an engineer changes
limits or calibration, with a reason.
"""

from enum import StrEnum
from typing import NamedTuple


class Role(StrEnum):
    """Role of a person."""

    OBSERVER = "observer"
    CLINICIAN = "clinician"
    ENGINEER = "engineer"


class Right(StrEnum):
    """Right to use a function of the console."""

    STOP = "stop"
    SEE_BEDSIDE = "see-bedside"
    SIGN_IN = "sign-in"
    CHANGE_OWN_PASSWORD = "change-own-password"
    SEE_SIGNALS = "see-signals"
    SEE_HISTORY = "see-history"
    SEE_AUDIT = "see-audit"
    ATTEND_ALARMS = "attend-alarms"
    START = "start"
    ATTEND_PATIENT = "attend-patient"
    CHOOSE_PROTOCOL = "choose-protocol"
    TEACH = "teach"
    RESET = "reset"
    CHANGE_CATHETER = "change-catheter"
    CHANGE_LIMITS = "change-limits"
    CALIBRATE = "calibrate"
    MANAGE_ACCOUNTS = "manage-accounts"
    MANAGE_TOKENS = "manage-tokens"


class Permission(NamedTuple):
    """Holders of a right."""

    sentence: str
    """What it lets a person do."""
    roles: frozenset[Role]
    by_anybody: bool = False
    """Without signing in."""
    by_administrator: bool = False
    """By an administrator, whatever the role."""
    needs_reason: bool = False
    """Only with a reason, which is put on record."""
    is_read_only: bool = False
    """Changes nothing; the only kind that a token of another program may have."""


_ALL = frozenset(Role)
_STAFF = frozenset({Role.CLINICIAN, Role.ENGINEER})
_CLINICIAN = frozenset({Role.CLINICIAN})
_ENGINEER = frozenset({Role.ENGINEER})
_NOBODY: frozenset[Role] = frozenset()

RIGHTS = {
    Right.STOP: Permission("Stop: abort the cycle and come out", _ALL, by_anybody=True),
    Right.SEE_BEDSIDE: Permission(
        "See where the catheter is, vacuum, phase and alarms",
        _ALL,
        by_anybody=True,
        is_read_only=True,
    ),
    Right.SIGN_IN: Permission("Sign in", _ALL, by_anybody=True),
    Right.CHANGE_OWN_PASSWORD: Permission("Change one's own password", _ALL),
    Right.SEE_SIGNALS: Permission("See and export signals at full rate", _ALL, is_read_only=True),
    Right.SEE_HISTORY: Permission(
        "See past cycles, alarms and reports, and take recordings", _ALL, is_read_only=True
    ),
    Right.SEE_AUDIT: Permission(
        "See who did what, and whether the records are whole",
        _ENGINEER,
        by_administrator=True,
        is_read_only=True,
    ),
    Right.ATTEND_ALARMS: Permission("Acknowledge alarms and pause their sound", _STAFF),
    Right.START: Permission("Start a cycle", _CLINICIAN),
    Right.ATTEND_PATIENT: Permission("Say that the patient was assessed or oxygenated", _CLINICIAN),
    Right.CHOOSE_PROTOCOL: Permission("Choose a protocol and a patient", _CLINICIAN),
    Right.TEACH: Permission("Teach the travel length", _CLINICIAN),
    Right.RESET: Permission("Leave a halt once its cause has been dealt with", _STAFF),
    Right.CHANGE_CATHETER: Permission("Take out of service, change the catheter", _STAFF),
    Right.CHANGE_LIMITS: Permission("Change limits", _ENGINEER, needs_reason=True),
    Right.CALIBRATE: Permission("Identify and calibrate the machine", _ENGINEER, needs_reason=True),
    Right.MANAGE_ACCOUNTS: Permission("Manage accounts", _NOBODY, by_administrator=True),
    Right.MANAGE_TOKENS: Permission(
        "Manage tokens of other programs", _NOBODY, by_administrator=True
    ),
}
"""Every right."""

ANYBODY = frozenset(right for right, permission in RIGHTS.items() if permission.by_anybody)
"""What needs no sign-in."""
MUST_CHANGE = ANYBODY | {Right.CHANGE_OWN_PASSWORD}
"""What somebody may do who signed in with a one-time password."""
READ_ONLY = frozenset(right for right, permission in RIGHTS.items() if permission.is_read_only)
"""What a token of another program may have."""


def rights_of(role: Role, is_administrator: bool) -> frozenset[Right]:
    """All that a person of this role may do."""
    return frozenset(
        right
        for right, permission in RIGHTS.items()
        if permission.by_anybody
        or role in permission.roles
        or (is_administrator and permission.by_administrator)
    )


def list_plain() -> list[dict[str, str | bool | list[str]]]:
    """The table as a page takes it, in its own order."""
    return [
        {
            "right": str(right),
            "sentence": permission.sentence,
            "roles": [str(role) for role in Role if role in permission.roles],
            "by_anybody": permission.by_anybody,
            "by_administrator": permission.by_administrator,
            "needs_reason": permission.needs_reason,
            "is_read_only": permission.is_read_only,
        }
        for right, permission in RIGHTS.items()
    ]
