"""Plain data: what JSON can say."""

import math
from typing import Any

Json = dict[str, Any]


def without_nan(data: Json) -> Json:
    """The same data with every number that is not finite as None: JSON has no NaN."""
    return {key: _finite(value) for key, value in data.items()}


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return without_nan(value)
    if isinstance(value, list | tuple):
        return [_finite(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
