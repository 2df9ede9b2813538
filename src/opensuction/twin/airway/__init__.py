"""Tube, trachea, carina and what the tip meets there."""
