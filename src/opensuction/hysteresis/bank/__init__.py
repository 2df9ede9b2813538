"""Banks of plays: one memory for many readouts."""
