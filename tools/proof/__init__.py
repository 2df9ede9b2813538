"""Symbolic execution of the core's own functions, so that what is claimed of them can be proved."""
