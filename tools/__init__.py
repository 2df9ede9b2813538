"""Checks of the source: proofs, mutation testing, traceability of hazards and requirements."""
