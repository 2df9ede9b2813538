"""Signals at full rate, as bytes: none of them passes through an object for each sample."""
