"""Timing and communication of one machine's processes: deadlines, rings, requests."""
