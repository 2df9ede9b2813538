"""Calibrating a machine."""
