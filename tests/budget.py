"""How many examples a property is tried with."""

from hypothesis import settings

simulated = settings(max_examples=max(settings().max_examples // 4, 25))
"""For a property whose every example simulates up to seconds, tick by tick from Python."""
