"""Units in terms of one another, and what of physics more than one room goes by."""

HOUR_S = 3600.0
ML_PER_S = 1000.0 / 60.0
"""mL/s for each L/min."""
PA_PER_MMHG = 133.322
ATMOSPHERE_MMHG = 760.0
BLASIUS_POWER = 19.0 / 7.0
"""Turbulent flow through a pipe at a given pressure loss grows with this power of its bore."""
