"""The report of a safety case."""
