"""Numbers that are as good as nothing.

What decays to zero never gets there: it halves and halves. Below 1e-308 a processor takes some
hundred cycles for each sum or product with such a number; a controller that has been at rest for
half a minute then takes half as long again for a tick, and nothing has changed but the time.
"""

from opensuction.kernel.compiled import compiled

TINY = 1e-30
"""Less is nothing, in whatever unit: also its square is far from where numbers become slow."""


@compiled
def drop_tiny(value: float) -> float:
    """The value; 0 where it is as good as nothing."""
    return 0.0 if abs(value) < TINY else value
