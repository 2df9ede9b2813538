"""Every hazard, its alarm and its safe state."""
