"""Traceability: every hazard has a fault that runs, every requirement a test that verifies it."""
