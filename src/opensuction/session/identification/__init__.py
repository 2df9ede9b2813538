"""Identifying models on a recording."""
