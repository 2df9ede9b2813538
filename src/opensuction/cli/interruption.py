"""Ctrl-C, which works within a second whatever is being computed."""

import os
import sys
from collections.abc import Callable
from typing import NoReturn

import typer

EXIT_INTERRUPTED = 130


def leave() -> NoReturn:
    """Exit at once: a compilation in the background knows no interruption."""
    print("opensuction: interrupted; nothing was written", file=sys.stderr)  # noqa: T201
    sys.stderr.flush()
    os._exit(EXIT_INTERRUPTED)


def carry_out(work: Callable[[], int]) -> NoReturn:
    """Exit with the status that a command returns; Ctrl-C leaves at once."""
    try:
        code = work()
    except KeyboardInterrupt:
        leave()
    raise typer.Exit(code)
