"""Bounds of a recording: how large it may be, and how much of it may be missing."""

MOST_SAMPLES = 2_000_000
"""Samples of a recording: an hour at 500 Hz. Three columns of it take 48 MB, and the slowest
estimator still answers in minutes (assumed)."""

LARGEST_TEXT_BYTES = 1_000_000_000
"""Text is read through once, cell by cell: this much takes about half a minute."""


def megabytes(size_bytes: int) -> int:
    """Size in MB for a message, rounded up."""
    return -(-size_bytes // 1_000_000)


def describe_excess(samples: int) -> str:
    """Describe a recording with more samples than the bound."""
    return (
        f"has {samples} rows or more, above the limit of {MOST_SAMPLES}; keep every "
        f"{-(-samples // MOST_SAMPLES)}th row or fewer cycles"
    )


def describe_missing(rows: int, of: int) -> str:
    """Describe rows that lack a number, with a remedy."""
    return f"(in {rows} of {of} rows); fill it in, or leave such rows out with --skip-missing"
