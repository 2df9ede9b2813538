"""Spontaneous behaviour of patients: coughs, breaths, movements; and artefacts of the oximeter."""
