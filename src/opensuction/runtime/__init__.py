"""The controller against the clock: the call that a tick is, and all that stands on it."""
