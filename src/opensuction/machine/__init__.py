"""Machines that a controller can be put before: what it asks of each, and those that there are."""
