"""A model's parameters from a recording."""
