"""Hysteresis models on recordings of other laboratories, by their error on what was held out."""
