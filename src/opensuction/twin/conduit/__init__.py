"""Conduits of other classes than the twin's own: what they do with a head's travel."""
