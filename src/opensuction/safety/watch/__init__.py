"""Evaluation of the readings against the limits."""
