"""What a setting means, beside its type and range, so that the documentation can show it."""

from typing import NamedTuple


class Meaning(NamedTuple):
    """Annotation of a field: ``Annotated[float, Gt(0), Meaning("...")]``."""

    text: str
