"""How the machine moves: servos, motion profiles, compensation of the transmission."""
