"""Distance of each threshold of the controller from the readings of a sound machine."""
