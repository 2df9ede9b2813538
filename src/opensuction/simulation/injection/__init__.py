"""Runs with faults, and what must hold in them."""
