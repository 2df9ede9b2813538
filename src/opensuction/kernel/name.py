"""Members of enumerations as files, the command line and people read them."""

from enum import Enum
from typing import TypeVar

Member = TypeVar("Member", bound=Enum)


def name_of(member: Enum) -> str:
    """``CATHETER_JAMMED`` is ``catheter-jammed``."""
    return member.name.lower().replace("_", "-")


def by_name(enumeration: type[Member]) -> dict[str, Member]:
    """Its members by those names, aliases by theirs."""
    members = enumeration.__members__.items()
    return {name.lower().replace("_", "-"): member for name, member in members}
