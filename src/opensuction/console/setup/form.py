"""Request bodies of the set-up routes."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from opensuction.console.setup.teach import Step

STRICT = ConfigDict(extra="forbid", strict=True)

Key = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{7,39}$")]
"""Of this request, made by who sends it: one that comes twice is obeyed once."""
Version = Annotated[int, Field(ge=0, le=2**31 - 1)]
"""Of the settings that somebody has looked at."""
Reason = Annotated[str, Field(max_length=500)]
Name = Annotated[str, Field(min_length=1, max_length=64)]
Number = float | int | bool | None | Annotated[str, Field(max_length=64)]
"""What a field of a form may hold, whether it means something or not."""
Numbers = Annotated[dict[Annotated[str, Field(max_length=64)], Number], Field(max_length=32)]


class DraftBody(BaseModel):
    """A draft of a protocol."""

    model_config = STRICT

    name: Name | None = None
    """None: of the clinical protocol that it is, or the present one's, changed."""
    approach: Literal["travel", "contact"]
    carina: Literal["known", "taught"] = "known"
    protocol: Numbers


class ProtocolBody(DraftBody):
    """A protocol to be set."""

    version: Version
    key: Key
    reason: Reason | None = None


class PatientBody(BaseModel):
    """A patient."""

    model_config = STRICT

    pseudonym: Annotated[str, Field(max_length=64)]
    age: Literal["neonate", "child", "adult"] | None = None
    tube_mm: Annotated[float, Field(gt=0, le=15)] | None = None
    weight_kg: Annotated[float, Field(gt=0, le=500)] | None = None
    version: Version
    key: Key


class CatheterBody(BaseModel):
    """A catheter that has been put in."""

    model_config = STRICT

    label: Annotated[str, Field(max_length=64)]
    key: Key


class TeachingBody(BaseModel):
    """A step of teaching."""

    model_config = ConfigDict(extra="forbid")

    step: Step
    version: Version = 0
    """Of the settings, for the steps that change them."""
    key: Key


class ReasonBody(BaseModel):
    """Reason for a change."""

    model_config = STRICT

    reason: Reason
    version: Version = 0
    key: Key
