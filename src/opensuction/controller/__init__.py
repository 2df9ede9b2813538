"""Composition of procedure, control and governor into one pure step."""
