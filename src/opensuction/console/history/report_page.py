"""A report as a console serves it: its own scripts run, and nothing else that may be in it.

It is sandboxed, so that it has an origin of its own and no cookie of anybody's; it may ask nobody
for anything. Scripts are let through by the hashes of those that the report is made with, worked
out from the program's files and not from the page: what got into a page by a name or a detail
has another hash.
"""

import base64
import hashlib
from functools import cache

from opensuction.report import html
from opensuction.report.cycle import page


@cache
def policy() -> str:
    """The content security policy of a report."""
    scripts = [html.read("vendor", "uPlot.iife.min.js")]
    scripts += [html.read("template", name) for name in page.SCRIPTS]
    hashes = " ".join(f"'sha256-{_hash(one)}'" for one in scripts)
    return "; ".join(
        (
            "sandbox allow-scripts allow-modals",
            "default-src 'none'",
            f"script-src {hashes}",
            # Widths of the phases stand in attributes; a style can fetch nothing here.
            "style-src 'unsafe-inline'",
            "img-src data:",
            "base-uri 'none'",
            "form-action 'none'",
            # It is shown within the console's page: STOP stays in reach.
            "frame-ancestors 'self'",
        )
    )


def _hash(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
