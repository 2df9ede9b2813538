"""Sets of numbered things as bit masks: bit ``n`` is the thing of number ``n``."""

from opensuction.kernel.compiled import compiled


@compiled
def flag(holds: bool, number: int) -> int:
    """Mask with the bit of a number if something holds, else 0."""
    return 1 << number if holds else 0
