"""The steps of a cycle, one tick at a time."""
