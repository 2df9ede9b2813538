"""Straight-line code that is generated for the fields of a record or the elements of a tuple."""
