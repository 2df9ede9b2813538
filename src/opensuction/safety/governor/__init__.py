"""Governor: limits the commands to the drives."""
