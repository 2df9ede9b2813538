"""Meaning of a setting beside its type and range, for the documentation."""

from typing import NamedTuple


class Meaning(NamedTuple):
    """Annotation of a field: ``Annotated[float, Gt(0), Meaning("...")]``."""

    text: str
