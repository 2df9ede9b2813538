"""Readouts of a bank of plays, from a recording."""
