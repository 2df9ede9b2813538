"""Catalogue of the hysteresis models, one entry each."""
