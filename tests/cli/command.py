"""Runs the command line as a user would: a process of its own."""

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path


def opensuction(
    *arguments: str, cwd: Path, environment: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run ``opensuction`` with these arguments in a folder; output is captured as text."""
    return subprocess.run(
        [sys.executable, "-m", "opensuction.cli.app", *arguments],
        cwd=cwd,
        env={**os.environ, **(environment or {})},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
