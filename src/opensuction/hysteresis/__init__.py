"""Hysteresis models between the catheter's head and its tip, one model a file."""
