"""Sensors of the machine, as imperfect as such parts are sold."""
