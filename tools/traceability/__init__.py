"""Traceability: every hazard has a fault that runs, every requirement a test that verifies it.

And the form of the docstrings by which a reader finds a module.
"""
