"""Access rights as a table: a row for each right, a column for each role."""

from docs.generator.document import table
from opensuction.accounts.rule.right import RIGHTS, Permission, Role

YES = "yes"


def markdown() -> str:
    """Every right, and who has it."""
    columns = ("", "right", "anybody", *Role, "administrator", "")
    rows = [
        (
            permission.sentence,
            f"`{right}`",
            *_list_marks(permission),
            "with a reason" if permission.needs_reason else "",
        )
        for right, permission in RIGHTS.items()
    ]
    return "\n".join(["", *table(columns, rows), "", ""])


def _list_marks(permission: Permission) -> list[str]:
    everybody = permission.by_anybody
    has = [everybody, *(everybody or role in permission.roles for role in Role)]
    has.append(everybody or permission.by_administrator)
    return [YES if one else "" for one in has]
