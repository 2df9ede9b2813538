"""Data that a page carries for its scripts."""

import json
import re
from typing import Any


def payload(html: str) -> dict[str, Any]:
    """The JSON object of a page."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', html, re.S)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data
