"""The report of one cycle."""
