"""Budget of examples for properties that are slow to try."""

from hypothesis import settings

simulated = settings(max_examples=max(settings().max_examples // 4, 25))
"""For a property whose every example simulates up to seconds, tick by tick from Python."""
