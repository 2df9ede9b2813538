"""Alarms that are announced to people."""
