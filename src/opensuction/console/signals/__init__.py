"""Signals at full rate: from rows of the control loop's ring to what a page draws."""
