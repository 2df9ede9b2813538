"""Writes what the documentation takes from the code: tables, diagrams, whole pages."""
