"""Motion control: servos, motion profiles, compensation of the transmission."""
