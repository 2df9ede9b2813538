"""Plain data: what JSON can say."""

import math
from typing import Any

Json = dict[str, Any]


def without_nan(value: Any) -> Any:
    """The same data with every number that is not finite as None: JSON has no NaN."""
    if isinstance(value, dict):
        return {key: without_nan(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [without_nan(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
